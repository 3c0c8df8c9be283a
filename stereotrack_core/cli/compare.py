"""``stereotrack compare``: runs against each other, with what their frames can show."""

from __future__ import annotations

import string
from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stereotrack_core.cli.arguments import add_frames, add_json, add_segments
from stereotrack_core.cli.command import OK, Command
from stereotrack_core.cli.comparison_tables import (
    apart_table,
    comparison_facts,
    comparison_table,
)
from stereotrack_core.cli.output import put, put_json, put_table, say
from stereotrack_core.cli.sources import (
    Truth,
    read_measured,
    segments_beside_runs,
    truth_of,
    warn_about_size,
)
from stereotrack_core.errors import InputError
from stereotrack_core.recording.selection import frame_bounds

if TYPE_CHECKING:
    from stereotrack_core.evaluation.comparison.compare import Candidate
    from stereotrack_core.recording.description import Segment
    from stereotrack_core.recording.landmarks import LandmarkTrajectory
    from stereotrack_core.tracking.frame import Run

_END = 2**62


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument(
        "run_files",
        type=Path,
        nargs="+",
        metavar="RUN",
        help="two runs (.npz) or more, or landmarks (.csv, .trc, .c3d); the first is what the "
        "others are compared with",
    )
    parser.add_argument(
        "--reference",
        type=Path,
        metavar="FILE",
        help="landmarks taken as truth; a run knows its recording's own. Without any, runs are "
        "compared with each other alone",
    )
    add_frames(parser)
    add_segments(parser)
    add_json(parser)


def run(args: Namespace) -> int:
    """Compare and print."""
    from stereotrack_core.evaluation.comparison.compare import compare, compare_segments
    from stereotrack_core.evaluation.comparison.words import how_it_is_made

    if len(args.run_files) > len(string.ascii_uppercase):
        raise InputError("these are too many runs", remedy="Compare up to 26 at once.")
    frames = _frames(args.frames)
    read = [read_measured(path) for path in args.run_files]
    candidates = _candidates(read)
    stored = [one for _, one in read if one is not None]
    truth = _truth(args.reference, stored)
    _warn(args.run_files, stored, truth)
    reference = None if truth is None else truth.reference
    whole = compare(candidates, reference, frames)
    parts: Sequence[tuple[str, Any]] = ()
    if args.segments:
        parts = compare_segments(candidates, reference, _segments(truth, stored), frames)
    source = None if truth is None else truth.source
    if args.json:
        facts: dict[str, Any] = {"runs": dict(zip(whole.names, args.run_files, strict=True))}
        facts["reference"] = source
        facts |= comparison_facts(whole)
        if args.segments:
            facts["segments"] = [
                {"name": name} | ({} if part is None else comparison_facts(part))
                for name, part in parts
            ]
        put_json(facts)
        return OK
    for name, path in zip(whole.names, args.run_files, strict=True):
        put(f"{name}  {path}")
    put(f"Reference: {source}\n" if source is not None else "No reference.\n")
    for title, comparison in (("", whole), *parts):
        if comparison is None:
            put(f"{title}: no frame that all runs have.\n")
            continue
        for pair in comparison.pairs:
            put_table(comparison_table(comparison, pair, title))
            if not comparison.against_reference:
                put_table(apart_table(pair, title))
    put(how_it_is_made(whole))
    return OK


def _candidates(read: Sequence[tuple[LandmarkTrajectory, Run | None]]) -> list[Candidate]:
    """The files by letters, which fit into a table and into a sentence."""
    from stereotrack_core.evaluation.comparison.compare import Candidate

    return [
        Candidate(letter, trajectory, None if stored is None else stored.unexplained_fraction)
        for letter, (trajectory, stored) in zip(string.ascii_uppercase, read, strict=False)
    ]


def _truth(given: Path | None, stored: Sequence[Run]) -> Truth | None:
    """What is named, else what the first run's recording has; None where there is nothing."""
    if given is not None:
        return truth_of(given, stored[0].meta if stored else {})
    if not stored:
        say("These files do not say which recording they belong to; there is no reference.")
        return None
    try:
        return truth_of(None, stored[0].meta)
    except InputError as error:
        say(f"{error.where}: {error.what}; the runs are compared with each other alone.")
        return None


def _segments(truth: Truth | None, stored: Sequence[Run]) -> Sequence[Segment]:
    return segments_beside_runs(truth, stored[0].meta if stored else {})


def _frames(text: str | None) -> range | None:
    if text is None:
        return None
    first, end = frame_bounds(text)
    return range(first or 0, _END if end is None else end)


def _warn(paths: Sequence[Path], stored: Sequence[Run], truth: Truth | None) -> None:
    prints = {str(one.meta["fingerprint"]) for one in stored if one.meta.get("fingerprint")}
    if len(prints) > 1:
        say(
            f"These runs are of {len(prints)} recordings, so their differences mean nothing: "
            f"{', '.join(map(str, paths))}."
        )
    if truth is not None:
        warn_about_size(truth)


COMMAND = Command(
    name="compare",
    summary="runs against each other: by how much one is better, and whether that can be told",
    description=(
        "Compare runs over the frames that all of them have: every measure of `evaluate` where "
        "there is a reference, how far the runs are apart where there is none. Differences are "
        "paired frame by frame; their 95 % intervals come from blocks of frames, because "
        "neighbouring frames are alike."
    ),
    add_arguments=add_arguments,
    run=run,
)
