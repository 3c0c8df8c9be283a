"""``stereotrack evaluate``: the errors of a run against a reference."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stereotrack_core.cli.arguments import add_frames, add_json, add_segments
from stereotrack_core.cli.command import OK, Command
from stereotrack_core.cli.error_tables import (
    doubt_facts,
    error_facts,
    error_table,
    segment_table,
)
from stereotrack_core.cli.output import put, put_json, put_table, say
from stereotrack_core.cli.sources import read_measured, segments_of, truth_of, warn_about_size
from stereotrack_core.errors import InputError
from stereotrack_core.recording.selection import frame_bounds

if TYPE_CHECKING:
    from stereotrack_core.evaluation.doubts import Doubts
    from stereotrack_core.evaluation.errors import LimbErrors
    from stereotrack_core.evaluation.summary import Summary
    from stereotrack_core.recording.landmarks import LandmarkTrajectory
    from stereotrack_core.tracking.frame import Run


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument(
        "run_file",
        type=Path,
        metavar="RUN",
        help="run or reference (.npz), or landmarks (.csv, .trc, .c3d)",
    )
    parser.add_argument(
        "--reference",
        type=Path,
        metavar="FILE",
        help="reference landmarks (.csv, .trc, .c3d), or with their uncertainty (.npz of "
        "`stereotrack fit`); by default the reference of the run's recording",
    )
    add_frames(parser)
    add_segments(parser)
    add_json(parser)


def run(args: Namespace) -> int:
    """Measure and print."""
    from stereotrack_core.evaluation.errors import errors_against
    from stereotrack_core.evaluation.reference_quality import reference_quality
    from stereotrack_core.evaluation.summary import summarise, summarise_segments

    trajectory, stored = read_measured(args.run_file)
    meta = {} if stored is None else dict(stored.meta)
    truth = truth_of(args.reference, meta)
    errors = _chosen(errors_against(trajectory, truth.reference), args.frames)
    _warn_about_frames(trajectory, errors, args.frames)
    warn_about_size(truth)
    summary = summarise(errors)
    parts = summarise_segments(errors, segments_of(truth)) if args.segments else ()
    speed = _frames_per_second(trajectory, meta)
    doubts = _doubts(stored, errors)
    quality = {} if truth.states is None else reference_quality(truth.states, errors.frame)
    if args.json:
        facts = {"run": args.run_file, "reference": truth.source, "frames_per_second": speed}
        facts |= error_facts(summary, quality)
        if doubts is not None:
            facts["lost_limbs"] = doubt_facts(doubts)
        if args.segments:
            facts["segments"] = [error_facts(part) for part in parts]
        put_json(facts)
        return OK
    title = f"{args.run_file} against {truth.source}"
    put_table(error_table(summary, title, speed, doubts, quality))
    if quality:
        put(_in_words(summary, quality))
    if args.segments:
        put_table(segment_table(parts))
    return OK


def _in_words(summary: Summary, quality: Mapping[str, float]) -> str:
    """Mean errors with how good the reference is: ``forearms 9.1 deg, reference good to 2.3``."""
    from stereotrack_core.evaluation.reference_quality import stated

    said = [
        f"{measure.label} {stated(measure.statistics.mean, measure.unit, quality, measure.name)}"
        for measure in summary.measures
        if measure.name in ("torso_long", "torso_cross", "upper_arms", "forearms")
    ]
    return f"Means: {'; '.join(said)}.\n"


def _doubts(stored: Run | None, errors: LimbErrors) -> Doubts | None:
    """How right the run is about its lost limbs; None where it does not say."""
    from stereotrack_core.evaluation.doubts import doubts_against

    if stored is None:
        return None
    doubts = doubts_against(stored.frame, stored.limb_lost, errors)
    return doubts if doubts.judged else None


def _chosen(errors: LimbErrors, frames: str | None) -> LimbErrors:
    if frames is not None:
        first, end = frame_bounds(frames)
        last = int(errors.frame[-1]) + 1 if len(errors.frame) else 0
        errors = errors.between(first or 0, last if end is None else end)
    if not len(errors.frame):
        raise InputError(
            "the reference contains none of the frames",
            where="--frames" if frames else "--reference",
            remedy="Choose frames that it contains.",
        )
    return errors


def _warn_about_frames(
    trajectory: LandmarkTrajectory, errors: LimbErrors, frames: str | None
) -> None:
    import numpy as np

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


COMMAND = Command(
    name="evaluate",
    summary="compute the errors of a run against the reference, with the thesis's measures",
    description=(
        "Print mean, median and 95th percentile of torso position, torso axes, upper arms and "
        "forearms against the reference, and the share of arm segments more than 45 degrees off. "
        "Frames missing in the run count 90 degrees and 500 mm. Frames missing in the reference "
        "are not scored."
    ),
    add_arguments=add_arguments,
    run=run,
)
