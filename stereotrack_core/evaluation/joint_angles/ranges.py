"""Ranges of motion of joint angles, left against right, and errors against a reference."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.evaluation.joint_angles.definitions import (
    ANGLES,
    AngleDefinition,
    sided,
    wrapped,
)
from stereotrack_core.evaluation.joint_angles.motion import Motion
from stereotrack_core.evaluation.joint_angles.series import JointAngles
from stereotrack_core.recording.description import Segment

WHOLE = "all"
"""Name of the stretch that is the whole recording."""


@dataclass(frozen=True)
class AngleRange:
    """How one angle moves in a stretch; radians, NaN where nothing is known.

    Attributes
    ----------
    frames : int
        Frames in which the smooth angle is known.
    minimum, maximum, mean : float
        Of the smooth angle.
    range_sigma : float
        Standard deviation of the range, errors at both ends taken for independent.
    sigma : float
        Root mean square of the angle's standard deviation.
    peak_velocity, peak_velocity_sigma : float, radians per second
        Largest speed in either direction, and its standard deviation.
    """

    angle: AngleDefinition
    frames: int
    minimum: float
    maximum: float
    range: float
    range_sigma: float
    mean: float
    sigma: float
    peak_velocity: float
    peak_velocity_sigma: float

    def degrees(self) -> dict[str, float]:
        """Everything but the frames by its name, in degrees and degrees per second."""
        return _degrees(self, "minimum", "peak_velocity_sigma")


@dataclass(frozen=True)
class SideDifference:
    """The range of motion of one angle, left against right.

    Attributes
    ----------
    difference : float, radians
        Left minus right range.
    difference_sigma : float, radians
    symmetry : float
        Symmetry index (Robinson et al. 1987): the difference as a share of the mean of both
        ranges; 0 for equal ones, 2 where only the left moves, -2 where only the right does.
    """

    left: AngleRange
    right: AngleRange
    difference: float
    difference_sigma: float
    symmetry: float

    def degrees(self) -> dict[str, float]:
        """Both ranges, their difference and its uncertainty by name, in degrees."""
        values = (self.left.range, self.right.range, self.difference, self.difference_sigma)
        names = ("left_range", "right_range", "difference", "difference_sigma")
        return {name: math.degrees(value) for name, value in zip(names, values, strict=True)}


@dataclass(frozen=True)
class StretchMotion:
    """Ranges of motion of one stretch of frames.

    Attributes
    ----------
    name : str
        The segment, or ``"all"``.
    first, end : int
        Frames of it that there are, half-open; as the segment has them where there is none.
    ranges : tuple of AngleRange
        In the order of :data:`ANGLES`.
    sides : tuple of SideDifference
        Plane, elevation and axial rotation of the shoulder, and elbow flexion.
    """

    name: str
    first: int
    end: int
    ranges: tuple[AngleRange, ...]
    sides: tuple[SideDifference, ...]

    def of(self, name: str) -> AngleRange:
        """The range of an angle by its name; KeyError where there is none."""
        return {one.angle.name: one for one in self.ranges}[name]


def range_of_motion(
    angles: JointAngles, motion: Motion, segments: Sequence[Segment] = ()
) -> tuple[StretchMotion, ...]:
    """Ranges of motion: the whole first, then every segment.

    Parameters
    ----------
    angles : JointAngles
        Whose standard deviations are reported.
    motion : Motion
        Of the same angles; its smooth angles are what ranges are taken of.
    """
    first = int(angles.frame[0]) if len(angles.frame) else 0
    end = int(angles.frame[-1]) + 1 if len(angles.frame) else 0
    whole = Segment(WHOLE, first, end)
    return tuple(stretch_motion(angles, motion, stretch) for stretch in (whole, *segments))


def stretch_motion(angles: JointAngles, motion: Motion, stretch: Segment) -> StretchMotion:
    """Ranges of motion in one stretch of frames."""
    inside = (angles.frame >= stretch.first) & (angles.frame < stretch.end)
    ranges = tuple(
        _range(
            definition,
            motion.angle[inside, k],
            angles.sigma[inside, k],
            motion.velocity[inside, k],
            motion.velocity_sigma[inside, k],
        )
        for k, definition in enumerate(ANGLES)
    )
    sides = tuple(_difference(ranges[left], ranges[right]) for left, right in sided())
    first, end = stretch.first, stretch.end
    if inside.any():
        first, end = int(angles.frame[inside][0]), int(angles.frame[inside][-1]) + 1
    return StretchMotion(stretch.name, first, end, ranges, sides)


def _range(
    definition: AngleDefinition,
    angle: FloatArray,
    sigma: FloatArray,
    velocity: FloatArray,
    velocity_sigma: FloatArray,
) -> AngleRange:
    known = np.isfinite(angle)
    if not known.any():
        return AngleRange(definition, 0, *[math.nan] * 8)
    low, high = int(np.nanargmin(angle)), int(np.nanargmax(angle))
    fastest = int(np.nanargmax(np.abs(velocity)))
    return AngleRange(
        definition,
        frames=int(np.count_nonzero(known)),
        minimum=float(angle[low]),
        maximum=float(angle[high]),
        range=float(angle[high] - angle[low]),
        range_sigma=float(np.hypot(sigma[low], sigma[high])),
        mean=float(np.mean(angle[known])),
        sigma=float(np.sqrt(np.mean(np.square(sigma[known])))),
        peak_velocity=float(abs(velocity[fastest])),
        peak_velocity_sigma=float(velocity_sigma[fastest]),
    )


def _difference(left: AngleRange, right: AngleRange) -> SideDifference:
    difference, mean = left.range - right.range, 0.5 * (left.range + right.range)
    return SideDifference(
        left,
        right,
        difference=difference,
        difference_sigma=float(np.hypot(left.range_sigma, right.range_sigma)),
        symmetry=difference / mean if mean > 0 else float("nan"),
    )


@dataclass(frozen=True)
class AngleError:
    """Errors of one angle over frames; radians, NaN where nothing could be compared.

    Attributes
    ----------
    frames : int
        Frames in which both know the angle.
    mean_error, median, rms, p95 : float
        Mean error with its sign; median, root mean square and 95th percentile of its size.
    stated_sigma : float
        Root mean square of what is stated.
    within_two_sigma : float
        Share (0 to 1) of the errors within two stated standard deviations; NaN where none is
        stated. Of a normal distribution 0.95 are.
    """

    angle: AngleDefinition
    frames: int
    mean_error: float
    median: float
    rms: float
    p95: float
    stated_sigma: float
    within_two_sigma: float

    def degrees(self) -> dict[str, float]:
        """The angles among them by name, in degrees."""
        return _degrees(self, "mean_error", "stated_sigma")


def angle_errors(found: JointAngles, truth: JointAngles) -> tuple[AngleError, ...]:
    """Errors in the frames that both have, in the order of :data:`ANGLES`.

    What a reference states about itself adds to what the run states.
    """
    _, own, other = np.intersect1d(found.frame, truth.frame, return_indices=True)
    errors = wrapped(found.angle[own] - truth.angle[other])
    sigma = np.hypot(found.sigma[own], np.nan_to_num(truth.sigma[other]))
    return tuple(_error(one, errors[:, k], sigma[:, k]) for k, one in enumerate(ANGLES))


def _error(definition: AngleDefinition, error: FloatArray, sigma: FloatArray) -> AngleError:
    known = np.isfinite(error)
    error, stated = error[known], sigma[known]
    if not len(error):
        return AngleError(definition, 0, *[math.nan] * 6)
    size, says = np.abs(error), np.isfinite(stated)
    return AngleError(
        definition,
        frames=len(error),
        mean_error=float(error.mean()),
        median=float(np.median(size)),
        rms=float(np.sqrt(np.mean(size**2))),
        p95=float(np.percentile(size, 95)),
        stated_sigma=float(np.sqrt(np.mean(stated[says] ** 2))) if says.any() else math.nan,
        within_two_sigma=float(np.mean(size[says] <= 2.0 * stated[says]))
        if says.any()
        else math.nan,
    )


def _degrees(numbers: AngleRange | AngleError, first: str, last: str) -> dict[str, float]:
    """Numbers from the first to the last field named, in degrees."""
    names = [field.name for field in fields(numbers)]
    chosen = names[names.index(first) : names.index(last) + 1]
    return {name: math.degrees(getattr(numbers, name)) for name in chosen}
