"""``stereotrack evaluate`` and ``compare``: errors of a run, its angles, failures, other runs."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.cli.arguments import (
    FPS,
    FRAMES,
    JSON,
    OF_RUN,
    REFERENCE,
    SEGMENTS,
    STATED,
    Part,
    changes,
    flag,
    option,
)
from stereotrack_core.cli.evaluations import (
    Measured,
    Told,
    against_told,
    angles_told,
    failures_told,
)
from stereotrack_core.cli.output import OK, put, put_json, put_table, say
from stereotrack_core.cli.sources import (
    Truth,
    read_measured,
    recording_in,
    some_segments,
    stated_for,
    truth_of,
    warn_about_size,
)
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.accuracy import (
    accuracy_facts,
    accuracy_of,
    error_facts,
    stated_means,
)
from stereotrack_core.evaluation.summary import LimbErrors, none_of_the_frames
from stereotrack_core.recording.description import Segment
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.recording.selection import asked_frames
from stereotrack_core.report.run_tables import error_table, segment_table
from stereotrack_core.tables import Table
from stereotrack_core.tracking.run_checks import HEADING, heading_words

DESCRIPTION = (
    "Print mean, median and 95th percentile of torso position, torso axes, upper arms and "
    "forearms against the reference, and the share of arm segments more than 45 degrees off. "
    "Frames missing in the run count 90 degrees and 500 mm. Frames missing in the reference "
    "are not scored. With --angles, --failures or --against these are printed instead, and need "
    "no reference."
)

OPTIONS = (
    option("run_file RUN", "run or reference (.npz), or landmarks (.csv, .trc, .c3d)", type=Path),
    REFERENCE,
    OF_RUN,
    *STATED,
    FPS,
    FRAMES,
    SEGMENTS,
    flag("--angles", "joint angles: ranges, errors"),
    flag("--failures", "stretches in which limbs fail, with their probable causes"),
    changes("change how failures are detected, for example episode_error=30"),
    option(
        "--against RUN",
        "compare with another run or landmarks, frame by frame: how much better one is, and "
        "whether the difference is significant",
        type=Path,
    ),
    JSON,
)


def run(args: Namespace) -> int:
    """Measure and print."""
    wanted = args.angles or args.failures or args.against is not None
    if args.changes and not args.failures:
        raise InputError(
            "it changes how failures are detected", where="--set", remedy="Add --failures."
        )
    measured = measured_of(args, needs_truth=not wanted)
    told: dict[str, Told] = {}
    if not wanted and measured.truth is not None:
        told[""] = _errors_told(args, measured, measured.truth)
    if args.angles:
        told["angles"] = angles_told(args, measured)
    if args.failures:
        told["failures"] = failures_told(args, measured)
    if args.against is not None:
        told["against"] = against_told(args, measured)
    source = None if measured.truth is None else measured.truth.source
    if args.json:
        facts: dict[str, Any] = {"run": args.run_file, "reference": source}
        for name, (one, _) in told.items():
            facts |= {name: one} if name else one
        put_json(facts)
        return OK
    put_told([tables for _, tables in told.values()], source, states_it=wanted)
    return OK


def put_told(
    results: Sequence[Sequence[Table | str]], source: Path | None, *, states_it: bool = True
) -> None:
    """Print what results refer to, and their tables and sentences."""
    if states_it:
        put(f"Reference: {source}\n" if source is not None else "No reference.\n")
    for tables in results:
        for table in tables:
            if isinstance(table, str):
                put(f"{table}\n")
            else:
                put_table(table)


def measured_of(args: Namespace, *, needs_truth: bool) -> Measured:
    """Read what is asked for; without truth where there is none and it is not needed."""
    path = args.run_file
    stated = stated_for(args, path, args.against, args.reference)
    trajectory, stored = read_measured(path, stated.get(path), args.recording)
    meta = {} if stored is None else dict(stored.meta)
    truth = None
    try:
        truth = truth_of(args.reference, meta, trajectory, stated.get(args.reference))
        warn_about_size(truth)
    except InputError as error:
        if needs_truth or args.reference is not None:
            raise
        say(f"No reference: {error.what}.")
    segments: Sequence[Segment] = ()
    if args.segments:
        folder = Path(str(meta.get("recording_folder") or path.parent))
        recording = recording_in(folder) if truth is None else None
        known = recording.segments if recording is not None else ()
        segments = some_segments(known if truth is None else truth.segments, folder)
    return Measured(path, trajectory, stored, truth, asked_frames(args.frames), segments, stated)


def _errors_told(args: Namespace, measured: Measured, truth: Truth) -> Told:
    """The errors against the reference."""
    trajectory = measured.trajectory
    found = measured.run or trajectory
    meta = {} if measured.run is None else dict(measured.run.meta)
    accuracy = accuracy_of(found, truth.reference, truth.states, measured.segments, measured.frames)
    if not len(accuracy.errors.frame):
        raise none_of_the_frames("--frames" if args.frames else "--reference")
    _warn_about_frames(trajectory, accuracy.errors, args.frames)
    if heading := heading_words(meta.get(HEADING)):
        say(f"{measured.path}: {heading.what}. {heading.remedy}")
    speed = _frames_per_second(trajectory, meta)
    facts = {"frames_per_second": speed} | accuracy_facts(accuracy)
    title = f"{measured.path} against {truth.source}"
    tables: list[Any] = [error_table(accuracy, title, speed)]
    if accuracy.quality:
        tables.append(f"Means: {'; '.join(stated_means(accuracy))}.")
    if args.segments:
        facts["segments"] = [error_facts(part) for part in accuracy.segments]
        tables.append(segment_table(accuracy.segments))
    return facts, tables


def _warn_about_frames(
    trajectory: LandmarkTrajectory, errors: LimbErrors, frames: str | None
) -> None:
    absent = int((~np.isin(errors.frame, trajectory.frame)).sum())
    if absent:
        say(
            f"The run lacks {absent} of the {len(errors.frame)} frames of the reference. They "
            "count 90 deg and 500 mm."
            + ("" if frames else " Restrict the range with --frames A:B.")
        )


def _frames_per_second(trajectory: LandmarkTrajectory, meta: dict[str, Any]) -> float | None:
    seconds = meta.get("wall_seconds")
    if not isinstance(seconds, int | float) or not seconds > 0:
        return None
    return len(trajectory.frame) / float(seconds)


def _compare(args: Namespace) -> int:
    """Compare and print."""
    first, *others = args.run_files
    if not others:
        raise InputError("there is one run only", remedy="Give two runs or more.")
    source: Path | None = None
    found = []
    for other in others:
        asked = Namespace(**vars(args), run_file=other, against=first, recording=None)
        measured = measured_of(asked, needs_truth=False)
        source = None if measured.truth is None else measured.truth.source
        found.append((other, against_told(asked, measured)))
    if args.json:
        pairs = [{**facts, "run": other} for other, (facts, _) in found]
        put_json({"run": first, "reference": source, "pairs": pairs})
    else:
        put_told([tables for _, (_, tables) in found], source)
    return OK


COMPARE = Part(
    (
        "Compare runs over the frames they share: all measures of `evaluate` where there is a "
        "reference, otherwise the distance between the runs. Differences are paired by frame."
    ),
    (
        option(
            "run_files RUN",
            "two or more runs (.npz) or landmark files (.csv, .trc, .c3d); the others are "
            "compared with the first",
            type=Path,
            nargs="+",
        ),
        REFERENCE,
        *STATED,
        FRAMES,
        SEGMENTS,
        JSON,
    ),
    _compare,
)
