"""``stereotrack evaluate`` and ``compare``: errors of a run, its angles, failures, other runs."""

from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.cli import evaluations, options, sources
from stereotrack_core.cli.output import OK, put_result, say
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
from stereotrack_core.tracking.run_checks import HEADING, heading_words


@options.command(
    options.path("run_file RUN", "run or reference (.npz), or landmarks (.csv, .trc, .c3d)"),
    options.REFERENCE,
    options.OF_RUN,
    *options.STATED,
    options.FPS,
    options.FRAMES,
    options.SEGMENTS,
    options.flag("--angles", "joint angles: ranges, errors"),
    options.flag("--failures", "stretches in which limbs fail, with their probable causes"),
    options.changes("change how failures are detected, for example episode_error=30"),
    options.path(
        "--against RUN",
        "compare with another run or landmarks, frame by frame: how much better one is, and "
        "whether the difference is significant",
    ),
)
def run(args: Namespace) -> int:
    """Print mean, median and 95th percentile of torso position, torso axes, upper arms and
    forearms against the reference, and the share of arm segments more than 45 degrees off.
    Frames missing in the run count 90 degrees and 500 mm. Frames missing in the reference
    are not scored. With --angles, --failures or --against these are printed instead, and
    need no reference.
    """
    wanted = args.angles or args.failures or args.against is not None
    if args.changes and not args.failures:
        raise InputError(
            "it changes how failures are detected", where="--set", remedy="Add --failures."
        )
    measured = measured_of(args, needs_truth=not wanted)
    told: dict[str, evaluations.Told] = {}
    if not wanted and measured.truth is not None:
        told[""] = _errors_told(args, measured, measured.truth)
    if args.angles:
        told["angles"] = evaluations.angles_told(args, measured)
    if args.failures:
        told["failures"] = evaluations.failures_told(args, measured)
    if args.against is not None:
        told["against"] = evaluations.against_told(args, measured)
    source = None if measured.truth is None else measured.truth.source
    facts: dict[str, Any] = {"run": args.run_file, "reference": source}
    for name, (one, _) in told.items():
        facts |= {name: one} if name else one
    words = _words(source) if wanted else None
    tables = (table for _, own in told.values() for table in own)
    put_result(facts, words, *tables, as_json=args.json)
    return OK


def _words(source: Path | None) -> str:
    """Name the reference of results."""
    return "No reference." if source is None else f"Reference: {source}"


def measured_of(args: Namespace, *, needs_truth: bool) -> evaluations.Measured:
    """Read what is asked for; without truth where there is none and it is not needed."""
    path = args.run_file
    stated = sources.stated_for(args, path, args.against, args.reference)
    trajectory, stored = sources.read_measured(path, stated.get(path), args.recording)
    meta = {} if stored is None else dict(stored.meta)
    truth = None
    try:
        truth = sources.truth_of(args.reference, meta, trajectory, stated.get(args.reference))
        sources.warn_about_size(truth)
    except InputError as error:
        if needs_truth or args.reference is not None:
            raise
        say(f"No reference: {error.what}.")
    segments: Sequence[Segment] = ()
    if args.segments:
        folder = Path(str(meta.get("recording_folder") or path.parent))
        recording = sources.recording_in(folder) if truth is None else None
        known = recording.segments if recording is not None else ()
        segments = sources.some_segments(known if truth is None else truth.segments, folder)
    return evaluations.Measured(
        path, trajectory, stored, truth, asked_frames(args.frames), segments, stated
    )


def _errors_told(
    args: Namespace, measured: evaluations.Measured, truth: sources.Truth
) -> evaluations.Told:
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
    seconds = meta.get("wall_seconds")
    speed = None
    if isinstance(seconds, int | float) and seconds > 0:
        speed = len(trajectory.frame) / float(seconds)
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


@options.command(
    options.path(
        "run_files RUN",
        "two or more runs (.npz) or landmark files (.csv, .trc, .c3d); the others are compared "
        "with the first",
        nargs="+",
    ),
    options.REFERENCE,
    *options.STATED,
    options.FRAMES,
    options.SEGMENTS,
)
def compare(args: Namespace) -> int:
    """Compare runs over the frames they share: all measures of `evaluate` where there is a
    reference, otherwise the distance between the runs. Differences are paired by frame.
    """
    first, *others = args.run_files
    if not others:
        raise InputError("there is one run only", remedy="Give two runs or more.")
    source: Path | None = None
    found = []
    for other in others:
        asked = Namespace(**vars(args), run_file=other, against=first, recording=None)
        measured = measured_of(asked, needs_truth=False)
        source = None if measured.truth is None else measured.truth.source
        found.append((other, evaluations.against_told(asked, measured)))
    facts: dict[str, Any] = {"run": first, "reference": source}
    facts["pairs"] = [{**one, "run": other} for other, (one, _) in found]
    tables = (table for _, (_, own) in found for table in own)
    put_result(facts, _words(source), *tables, as_json=args.json)
    return OK
