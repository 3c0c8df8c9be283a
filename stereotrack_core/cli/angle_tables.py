"""Tables of joint angles for people, in degrees."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from stereotrack_core.cli.output import Table, number

if TYPE_CHECKING:
    from stereotrack_core.evaluation.joint_angles.errors import AngleError
    from stereotrack_core.evaluation.joint_angles.ranges import (
        AngleRange,
        SideDifference,
        StretchMotion,
    )

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
