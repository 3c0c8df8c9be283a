"""``stereotrack evaluate``: the errors of a run against a reference."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.cli.arguments import (
    FRAMES,
    JSON,
    LIMIT_OF_SIGMA,
    REFERENCE,
    SEGMENTS,
    STATED,
    option,
)
from stereotrack_core.cli.output import OK, put, put_json, put_table, say
from stereotrack_core.cli.sources import (
    limit_of_sigma,
    read_measured,
    some_segments,
    stated_for,
    truth_of,
    warn_about_size,
)
from stereotrack_core.evaluation.accuracy import (
    accuracy_facts,
    accuracy_of,
    error_facts,
    stated_means,
)
from stereotrack_core.evaluation.errors import LimbErrors, none_of_the_frames
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.recording.selection import asked_frames
from stereotrack_core.report.run_tables import error_table, segment_table
from stereotrack_core.tracking.run_checks import HEADING, heading_words

DESCRIPTION = (
    "Print mean, median and 95th percentile of torso position, torso axes, upper arms and "
    "forearms against the reference, and the share of arm segments more than 45 degrees off. "
    "Frames missing in the run count 90 degrees and 500 mm. Frames missing in the reference "
    "are not scored."
)

OPTIONS = (
    option(
        "run_file RUN", "run or reference (.npz), or landmarks (.csv, .trc, .c3d, .nc)", type=Path
    ),
    REFERENCE,
    *STATED,
    LIMIT_OF_SIGMA,
    FRAMES,
    SEGMENTS,
    JSON,
)


def run(args: Namespace) -> int:
    """Measure and print."""
    stated = stated_for(args, args.run_file, args.reference)
    trajectory, stored = read_measured(args.run_file, stated.get(args.run_file))
    meta = {} if stored is None else dict(stored.meta)
    limit = limit_of_sigma(args)
    truth = truth_of(args.reference, meta, trajectory, limit, stated.get(args.reference))
    segments = some_segments(truth.segments, truth.source) if args.segments else ()
    found = stored or trajectory
    accuracy = accuracy_of(
        found, truth.reference, truth.states, segments, asked_frames(args.frames), limit
    )
    if not len(accuracy.errors.frame):
        raise none_of_the_frames("--frames" if args.frames else "--reference")
    _warn_about_frames(trajectory, accuracy.errors, args.frames)
    warn_about_size(truth)
    if heading := heading_words(meta.get(HEADING)):
        say(f"{args.run_file}: {heading.what}. {heading.remedy}")
    speed = _frames_per_second(trajectory, meta)
    if args.json:
        facts = {"run": args.run_file, "reference": truth.source, "frames_per_second": speed}
        facts |= accuracy_facts(accuracy)
        if args.segments:
            facts["segments"] = [error_facts(part) for part in accuracy.segments]
        put_json(facts)
        return OK
    put_table(error_table(accuracy, f"{args.run_file} against {truth.source}", speed))
    if accuracy.quality:
        put(f"Means: {'; '.join(stated_means(accuracy))}.\n")
    if args.segments:
        put_table(segment_table(accuracy.segments))
    return OK


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
