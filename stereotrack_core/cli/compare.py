"""``stereotrack compare``: runs against each other, with what their frames can show."""

from __future__ import annotations

import math
import string
from argparse import Namespace
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from stereotrack_core.cli.arguments import FRAMES, JSON, REFERENCE, SEGMENTS, STATED, option
from stereotrack_core.cli.output import OK, put, put_json, put_table, say
from stereotrack_core.cli.sources import (
    Truth,
    read_measured,
    recording_in,
    say_notes,
    some_segments,
    stated_for,
    truth_of,
    warn_about_size,
)
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.accuracy import error_facts
from stereotrack_core.evaluation.comparison.compare import (
    Candidate,
    Comparison,
    Pair,
    compare,
    compare_segments,
    how_it_is_made,
    verdict,
)
from stereotrack_core.interop.landmark_file import Stated
from stereotrack_core.recording.description import Segment
from stereotrack_core.recording.frame_times import values_at
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.recording.selection import asked_frames
from stereotrack_core.report.run_tables import measure_rows
from stereotrack_core.tables import Table, number
from stereotrack_core.tracking.frame import Run

DESCRIPTION = (
    "Compare runs over the frames they share: all measures of `evaluate` where there is a "
    "reference, otherwise the distance between the runs. Differences are paired by frame. "
    "Their 95 % intervals use blocks of frames, because neighbouring frames are correlated."
)

OPTIONS = (
    option(
        "run_files RUN",
        "two or more runs (.npz) or landmark files (.csv, .trc, .c3d, .nc); the others are "
        "compared with the first",
        type=Path,
        nargs="+",
    ),
    REFERENCE,
    *STATED,
    FRAMES,
    SEGMENTS,
    JSON,
)


def run(args: Namespace) -> int:
    """Compare and print."""
    if len(args.run_files) > len(string.ascii_uppercase):
        raise InputError("too many runs", remedy="Compare at most 26 at once.")
    frames = asked_frames(args.frames)
    stated = stated_for(args, *args.run_files, args.reference)
    read = [read_measured(path, stated.get(path)) for path in args.run_files]
    candidates = _candidates(args.run_files, read)
    stored = [one for _, one in read if one is not None]
    truth = _truth(args, stored, candidates[0].trajectory, stated.get(args.reference))
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
            put(f"{title}: the runs have no frame in common.\n")
            continue
        for pair in comparison.pairs:
            put_table(comparison_table(comparison, pair, title))
            if not comparison.against_reference:
                put_table(apart_table(pair, title))
    put(how_it_is_made(whole))
    return OK


def _candidates(
    paths: Sequence[Path], read: Sequence[tuple[LandmarkTrajectory, Run | None]]
) -> list[Candidate]:
    """The files by letters, which fit into a table and into a sentence.

    All are compared at the frames of the first, by time.
    """
    fps, found = read[0][0].fps, []
    for letter, path, (own, stored) in zip(string.ascii_uppercase, paths, read, strict=False):
        at_first = own if fps is None else own.at_rate(fps, str(path))
        say_notes(at_first.notes[len(own.notes) :])
        unexplained = None if stored is None else stored.unexplained_fraction
        if unexplained is not None and fps and own.fps and at_first is not own:
            values = unexplained[:, None, None]
            unexplained = values_at(own.frame, values, own.fps, fps, at_first.frame)[:, 0, 0]
        found.append(Candidate(letter, at_first, unexplained))
    return found


def _truth(
    args: Namespace, stored: Sequence[Run], measured: LandmarkTrajectory, stated: Stated | None
) -> Truth | None:
    """What is named, else what the first run's recording has; None where there is nothing."""
    if args.reference is not None:
        meta = stored[0].meta if stored else {}
        return truth_of(args.reference, meta, measured, stated=stated)
    if not stored:
        say("No reference: the files do not state their recording.")
        return None
    try:
        return truth_of(None, stored[0].meta, measured)
    except InputError as error:
        say(f"{error.where}: {error.what}. The runs are only compared with each other.")
        return None


def _segments(truth: Truth | None, stored: Sequence[Run]) -> Sequence[Segment]:
    """Of the reference, or else of the first run's recording."""
    if truth is not None:
        return some_segments(truth.segments, truth.source)
    folder = Path(str(stored[0].meta.get("recording_folder") or "")) if stored else Path()
    recording = recording_in(folder)
    return some_segments(() if recording is None else recording.segments, folder)


def _warn(paths: Sequence[Path], stored: Sequence[Run], truth: Truth | None) -> None:
    prints = {str(one.meta["fingerprint"]) for one in stored if one.meta.get("fingerprint")}
    if len(prints) > 1:
        say(
            f"The runs are of {len(prints)} different recordings, so their differences are "
            f"meaningless: {', '.join(map(str, paths))}."
        )
    if truth is not None:
        warn_about_size(truth)


def comparison_table(comparison: Comparison, pair: Pair, title: str = "") -> Table:
    """Means of both runs, their difference with its interval, and what that comes to."""
    first, second = pair.first, pair.second
    frames = len(comparison.frames)
    where = f"{title}: " if title else ""
    heading = f"{where}{second} compared with {first}, means over {frames} frames"
    rows = [
        (
            f"{paired.measure.label} [{paired.measure.unit}]",
            number(paired.first_mean, 2),
            number(paired.second_mean, 2),
            f"{paired.difference:+z.2f}" if math.isfinite(paired.difference) else "-",
            f"{paired.low:+z.2f} to {paired.high:+z.2f}" if paired.enough else "-",
            f"{paired.better_percent:.0f} %" if math.isfinite(paired.better_percent) else "-",
            number(paired.p, 3),
            str(paired.block_frames),
            verdict(paired, first, second),
        )
        for paired in pair.measures
    ]
    columns = (
        *("measure", f">{first}", f">{second}", f">{second} - {first}", ">95 % interval"),
        *(f">{second} better in", ">p", ">block", "conclusion"),
    )
    return Table(heading, columns, rows)


def apart_table(pair: Pair, title: str = "") -> Table:
    """How far two runs are from each other."""
    where = f"{title}: " if title else ""
    rows = measure_rows(pair.apart)
    rows.append(("arm segments over 45 deg apart [%]", number(100.0 * pair.apart.lost), "", ""))
    heading = f"{where}{pair.second} and {pair.first}, distance from each other"
    return Table(heading, ("measure", ">mean", ">median", ">95 %"), rows)


def comparison_facts(comparison: Comparison) -> dict[str, Any]:
    """The same for JSON."""
    return {
        "frames": len(comparison.frames),
        "first_frame": comparison.frames[0],
        "last_frame": comparison.frames[-1],
        "against_reference": comparison.against_reference,
        "pairs": [_pair_facts(pair) for pair in comparison.pairs],
    }


def _pair_facts(pair: Pair) -> dict[str, Any]:
    measures = {}
    for paired in pair.measures:
        facts = asdict(paired)
        measures[paired.measure.name] = {
            "unit": facts.pop("measure")["unit"],
            **facts,
            "differs": paired.differs,
            "verdict": verdict(paired, pair.first, pair.second),
        }
    return {
        "first": pair.first,
        "second": pair.second,
        "measures": measures,
        "apart": error_facts(pair.apart),
    }
