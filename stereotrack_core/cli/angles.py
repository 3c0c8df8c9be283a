"""``stereotrack angles``: joint angles as a laboratory reports them."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.cli.arguments import (
    FPS,
    FRAMES,
    JSON,
    SEGMENTS,
    STATED,
    check_output,
    check_suffix,
    option,
)
from stereotrack_core.cli.output import OK, put_result, say
from stereotrack_core.cli.sources import (
    AngleSource,
    angle_source,
    angles_at,
    some_segments,
    stated_for,
)
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.errors import none_of_the_frames
from stereotrack_core.evaluation.joint_angles.motion import (
    CUT_OFF_HZ,
    SHORTEST,
    AngleError,
    StretchMotion,
    angle_errors,
    motion_of,
    range_of_motion,
)
from stereotrack_core.evaluation.joint_angles.series import JointAngles, angles_of_trajectory
from stereotrack_core.interop.landmark_file import Stated
from stereotrack_core.project.exporting.runs import write_angles
from stereotrack_core.recording.selection import asked_frames
from stereotrack_core.report.run_tables import range_table, side_table
from stereotrack_core.tables import Table, number

DESCRIPTION = (
    "Compute joint angles following the recommendations of the International Society of "
    "Biomechanics, as far as nine landmarks allow: shoulder plane of elevation, elevation and "
    "axial rotation, elbow flexion, rotation and tilt of torso and head. Each angle has a "
    "standard deviation if the file states its uncertainty. Sign conventions and undefined "
    "angles are described in docs/angles.md."
)

OPTIONS = (
    option(
        "source RUN|REFERENCE",
        "run or reference (.npz), or landmarks (.csv, .trc, .c3d, .nc)",
        type=Path,
    ),
    FRAMES,
    SEGMENTS,
    option(
        "--cutoff HZ",
        "cut-off frequency of the low-pass filter (default: 6; at most 0.4 of the frame rate)",
        type=float,
    ),
    FPS,
    option(
        "--reference FILE",
        "also print the errors of the angles against this reference; without a file name, "
        "against the recording's reference",
        nargs="?",
        const="",
    ),
    *STATED,
    option("-o --output FILE", "write the angles of every frame as a table (.csv)", type=Path),
    JSON,
)


def run(args: Namespace) -> int:
    """Work out and print."""
    if args.output is not None:
        check_suffix(args.output, ".csv")
        check_output(args.output)

    truth = Path(args.reference) if args.reference else None
    stated = stated_for(args, args.source, truth)
    source = angle_source(args.source, args.fps, stated.get(args.source))
    angles = _chosen(source.angles, args.frames)
    motion = motion_of(angles, source.fps, CUT_OFF_HZ if args.cutoff is None else args.cutoff)
    recording = source.recording
    known = () if recording is None else recording.segments
    segments = some_segments(known, args.source) if args.segments else ()
    stretches = range_of_motion(angles, motion, segments)
    errors = None if args.reference is None else _errors(args, source, angles, stated)
    if args.output is not None:
        write_angles(args.output, angles, source.fps, args.cutoff)
        say(f"Angles of every frame written to {args.output}.")
    facts: dict[str, Any] = {
        "source": args.source,
        "frames_per_second": source.fps,
        "cut_off_hz": motion.cut_off,
        "low_pass": motion.words,
        "stretches": [_range_facts(stretch) for stretch in stretches],
    }
    tables = [*map(range_table, stretches), side_table(stretches)]
    if errors is not None:
        facts["errors"] = {
            one.angle.name: {
                "frames": one.frames,
                **one.degrees(),
                "within_two_sigma": one.within_two_sigma,
            }
            for one in errors
        }
        tables.append(_error_table(errors))
    put_result(facts, *tables, as_json=args.json)
    if args.json:
        return OK
    say(motion.words)
    if not any(one.frames for one in stretches[0].ranges):
        say(f"No angle is known in {SHORTEST} consecutive frames, so ranges cannot be computed.")
    return OK


def _chosen(angles: JointAngles, frames: str | None) -> JointAngles:
    asked = asked_frames(frames)
    angles = angles.between(asked.start, asked.stop)
    if not len(angles.frame):
        raise InputError(
            "there are no frames to process",
            where="--frames" if frames is not None else "",
            remedy="Give a file with frames, or another frame range.",
        )
    return angles


def _errors(
    args: Namespace, source: AngleSource, angles: JointAngles, stated: Mapping[Path, Stated]
) -> Sequence[AngleError]:
    if args.reference:
        path = Path(args.reference)
        truth = angles_at(source, path, stated.get(path))
    elif source.recording is not None and source.recording.reference is not None:
        truth = angles_of_trajectory(source.recording.reference)
    else:
        raise InputError(
            "the recording of this file has no reference, or was not found",
            where=str(args.source),
            remedy="Give the reference with --reference FILE.",
        )
    if not np.isin(angles.frame, truth.frame).any():
        raise none_of_the_frames(str(args.reference or args.source))
    return angle_errors(angles, truth)


def _error_table(errors: Sequence[AngleError]) -> Table:
    headings = (
        *("angle", ">frames", ">mean error", ">median", ">rms", ">95 %"),
        *(">stated ±", ">within 2 ± %"),
    )
    rows = [
        (
            error.angle.words,
            str(error.frames),
            *map(number, error.degrees().values()),
            number(100.0 * error.within_two_sigma, 0),
        )
        for error in errors
        if error.frames
    ]
    return Table("Errors of the joint angles, degrees", headings, rows)


def _range_facts(stretch: StretchMotion) -> dict[str, Any]:
    """Ranges for JSON, degrees and degrees per second."""
    return {
        "name": stretch.name,
        "first": stretch.first,
        "end": stretch.end,
        "angles": {
            one.angle.name: {"frames": one.frames, **one.degrees()} for one in stretch.ranges
        },
        "sides": {
            side.left.angle.kind: {**side.degrees(), "symmetry_percent": 100.0 * side.symmetry}
            for side in stretch.sides
        },
    }
