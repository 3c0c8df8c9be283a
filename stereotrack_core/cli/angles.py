"""``stereotrack angles``: joint angles as a laboratory reports them."""

from __future__ import annotations

import math
from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stereotrack_core.cli.arguments import add_frames, add_json, add_segments, check_output
from stereotrack_core.cli.command import OK, Command
from stereotrack_core.cli.output import Table, number, put_json, put_table, say
from stereotrack_core.errors import InputError
from stereotrack_core.recording.selection import frame_bounds

if TYPE_CHECKING:
    from stereotrack_core.cli.sources import AngleSource
    from stereotrack_core.evaluation.joint_angles.errors import AngleError
    from stereotrack_core.evaluation.joint_angles.ranges import (
        AngleRange,
        SideDifference,
        StretchMotion,
    )
    from stereotrack_core.evaluation.joint_angles.series import JointAngles
    from stereotrack_core.recording.description import Segment


def add_arguments(parser: ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument(
        "source",
        type=Path,
        metavar="RUN|REFERENCE",
        help="run or reference (.npz), or landmarks (.csv, .trc, .c3d)",
    )
    add_frames(parser)
    add_segments(parser)
    parser.add_argument(
        "--cutoff",
        type=float,
        metavar="HZ",
        help="cut-off frequency of the low-pass filter (default: 6; at most 0.4 of the frame rate)",
    )
    parser.add_argument(
        "--fps",
        type=float,
        metavar="N",
        help="frames per second, for files that do not state it",
    )
    parser.add_argument(
        "--reference",
        nargs="?",
        const="",
        metavar="FILE",
        help="also print the errors of the angles against this reference; without a file name, "
        "against the recording's reference",
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FILE",
        help="write the angles of every frame as a table (.csv)",
    )
    add_json(parser)


def run(args: Namespace) -> int:
    """Work out and print."""
    if args.output is not None:
        if args.output.suffix.lower() != ".csv":
            raise InputError(
                "the angles of every frame can only be written as .csv",
                where="-o",
                remedy=f"Use the name {args.output.with_suffix('.csv').name}.",
            )
        check_output(args.output)
    from stereotrack_core.cli.sources import angle_source, write_angles
    from stereotrack_core.evaluation.joint_angles.motion import CUT_OFF_HZ, SHORTEST, motion_of
    from stereotrack_core.evaluation.joint_angles.ranges import range_of_motion

    source = angle_source(args.source, args.fps)
    angles = _chosen(source.angles, args.frames)
    motion = motion_of(angles, source.fps, CUT_OFF_HZ if args.cutoff is None else args.cutoff)
    stretches = range_of_motion(angles, motion, _segments(args, source))
    errors = None if args.reference is None else _errors(args, source, angles)
    if args.output is not None:
        write_angles(args.output, angles, source.fps, args.cutoff)
        say(f"Angles of every frame written to {args.output}.")
    if args.json:
        facts: dict[str, Any] = {
            "source": args.source,
            "frames_per_second": source.fps,
            "cut_off_hz": motion.cut_off,
            "low_pass": motion.words,
            "stretches": [range_facts(stretch) for stretch in stretches],
        }
        if errors is not None:
            facts["errors"] = error_facts(errors)
        put_json(facts)
        return OK

    for stretch in stretches:
        put_table(range_table(stretch))
    put_table(side_table(stretches))
    if errors is not None:
        put_table(angle_error_table(errors, "Errors of the joint angles, degrees"))
    say(motion.words)
    if not any(one.frames for one in stretches[0].ranges):
        say(f"No angle is known in {SHORTEST} consecutive frames, so ranges cannot be computed.")
    return OK


def _chosen(angles: JointAngles, frames: str | None) -> JointAngles:
    if frames is not None:
        first, end = frame_bounds(frames)
        last = int(angles.frame[-1]) if len(angles.frame) else 0
        angles = angles.between(first or 0, last + 1 if end is None else end)
    if not len(angles.frame):
        raise InputError(
            "there are no frames to process",
            where="--frames" if frames is not None else "",
            remedy="Give a file with frames, or another frame range.",
        )
    return angles


def _segments(args: Namespace, source: AngleSource) -> Sequence[Segment]:
    if not args.segments:
        return ()
    if not source.segments:
        raise InputError(
            "the recording has no segments",
            where=str(args.source),
            remedy="Add a segments.csv to the recording, or omit --segments.",
        )
    return source.segments


def _errors(args: Namespace, source: AngleSource, angles: JointAngles) -> Sequence[AngleError]:
    import numpy as np

    from stereotrack_core.cli.sources import angles_of_file
    from stereotrack_core.evaluation.joint_angles.errors import angle_errors

    truth = source.truth if not args.reference else angles_of_file(Path(args.reference))
    if truth is None:
        raise InputError(
            "the recording of this file has no reference, or was not found",
            where=str(args.source),
            remedy="Give the reference with --reference FILE.",
        )
    if not np.isin(angles.frame, truth.frame).any():
        raise InputError(
            "the reference contains none of the frames",
            where=str(args.reference or args.source),
            remedy="Choose frames that it contains.",
        )
    return angle_errors(angles, truth)


_DEGREES = 180.0 / math.pi


def range_table(stretch: StretchMotion) -> Table:
    """Range of motion, mean and peak velocity of every angle that is known."""
    headings = (
        *("angle", ">frames", ">from", ">to", ">range", ">± range", ">mean", ">± angle"),
        *(">peak deg/s", ">± peak"),
    )
    rows = [
        (
            one.angle.words,
            str(one.frames),
            *(
                number(_DEGREES * value)
                for value in (
                    one.minimum, one.maximum, one.range, one.range_sigma, one.mean, one.sigma,
                    one.peak_velocity, one.peak_velocity_sigma,
                )
            ),
        )
        for one in stretch.ranges
        if one.frames
    ]  # fmt: skip
    where = "all frames" if stretch.name == "all" else f"segment {stretch.name}"
    title = f"Joint angles, {where} ({stretch.first} to {stretch.end - 1}), degrees"
    return Table(title, headings, rows)


def side_table(stretches: Sequence[StretchMotion]) -> Table:
    """Ranges of motion, left against right."""
    headings = ("stretch", "angle", ">left", ">right", ">left - right", ">±", ">symmetry %")
    rows = [
        (
            stretch.name,
            side.left.angle.label,
            *(
                number(_DEGREES * value)
                for value in (
                    side.left.range, side.right.range, side.difference, side.difference_sigma
                )
            ),
            number(100.0 * side.symmetry),
        )
        for stretch in stretches
        for side in stretch.sides
        if side.left.frames or side.right.frames
    ]  # fmt: skip
    return Table("Range of motion, left against right, degrees", headings, rows)


def angle_error_table(errors: Sequence[AngleError], title: str) -> Table:
    """Errors of the angles against a reference."""
    headings = (
        *("angle", ">frames", ">mean error", ">median", ">rms", ">95 %"),
        *(">stated ±", ">within 2 ± %"),
    )
    rows = [
        (
            error.angle.words,
            str(error.frames),
            *(
                number(_DEGREES * value)
                for value in (error.bias, error.median, error.rms, error.p95, error.sigma)
            ),
            number(100.0 * error.within, 0),
        )
        for error in errors
        if error.frames
    ]
    return Table(title, headings, rows)


def range_facts(stretch: StretchMotion) -> dict[str, Any]:
    """The same for JSON; degrees and degrees per second."""
    return {
        "name": stretch.name,
        "first": stretch.first,
        "end": stretch.end,
        "angles": {one.angle.name: _range_facts(one) for one in stretch.ranges},
        "sides": {side.left.angle.kind: _side_facts(side) for side in stretch.sides},
    }


def error_facts(errors: Sequence[AngleError]) -> dict[str, Any]:
    """Errors for JSON, degrees."""
    return {
        error.angle.name: {
            "frames": error.frames,
            "mean_error": _DEGREES * error.bias,
            "median": _DEGREES * error.median,
            "rms": _DEGREES * error.rms,
            "p95": _DEGREES * error.p95,
            "stated_sigma": _DEGREES * error.sigma,
            "within_two_sigma": error.within,
        }
        for error in errors
    }


def _range_facts(one: AngleRange) -> dict[str, Any]:
    return {
        "frames": one.frames,
        "minimum": _DEGREES * one.minimum,
        "maximum": _DEGREES * one.maximum,
        "range": _DEGREES * one.range,
        "range_sigma": _DEGREES * one.range_sigma,
        "mean": _DEGREES * one.mean,
        "sigma": _DEGREES * one.sigma,
        "peak_velocity": _DEGREES * one.peak_velocity,
        "peak_velocity_sigma": _DEGREES * one.peak_velocity_sigma,
    }


def _side_facts(side: SideDifference) -> dict[str, Any]:
    return {
        "left_range": _DEGREES * side.left.range,
        "right_range": _DEGREES * side.right.range,
        "difference": _DEGREES * side.difference,
        "difference_sigma": _DEGREES * side.difference_sigma,
        "symmetry_percent": 100.0 * side.symmetry,
    }


COMMAND = Command(
    name="angles",
    summary="joint angles of a run or reference: ranges of motion, velocities, left-right "
    "differences",
    description=(
        "Compute joint angles following the recommendations of the International Society of "
        "Biomechanics, as far as nine landmarks allow: shoulder plane of elevation, elevation and "
        "axial rotation, elbow flexion, rotation and tilt of torso and head. Each angle has a "
        "standard deviation if the file states its uncertainty. Sign conventions and undefined "
        "angles are described in docs/angles.md."
    ),
    add_arguments=add_arguments,
    run=run,
)
