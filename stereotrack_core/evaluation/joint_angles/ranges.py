"""Range of motion, mean and peak velocity of every joint angle, and left against right."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.evaluation.joint_angles.definitions import ANGLES, AngleDefinition, sided
from stereotrack_core.evaluation.joint_angles.motion import Motion
from stereotrack_core.evaluation.joint_angles.series import JointAngles
from stereotrack_core.recording.description import Segment

WHOLE = "all"
"""Name of the stretch that is the whole recording."""


@dataclass(frozen=True)
class AngleRange:
    """How one angle moves in a stretch; NaN where nothing is known.

    Attributes
    ----------
    angle : AngleDefinition
    frames : int
        Frames in which the smooth angle is known.
    minimum, maximum, mean : float, radians
        Of the smooth angle.
    range : float, radians
        From minimum to maximum.
    range_sigma : float, radians
        Standard deviation of the range, errors at both ends taken for independent.
    sigma : float, radians
        Root mean square of the angle's standard deviation.
    peak_velocity, peak_velocity_sigma : float, radians per second
        Largest speed in either direction, and its standard deviation.
    """

    angle: AngleDefinition
    frames: int
    minimum: float
    maximum: float
    mean: float
    range: float
    range_sigma: float
    sigma: float
    peak_velocity: float
    peak_velocity_sigma: float


@dataclass(frozen=True)
class SideDifference:
    """The range of motion of one angle, left against right.

    Attributes
    ----------
    left, right : AngleRange
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
    segments : sequence of Segment
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
    nan = float("nan")
    known = np.isfinite(angle)
    if not known.any():
        return AngleRange(definition, 0, nan, nan, nan, nan, nan, nan, nan, nan)
    low, high = int(np.nanargmin(angle)), int(np.nanargmax(angle))
    fastest = int(np.nanargmax(np.abs(velocity)))
    return AngleRange(
        definition,
        frames=int(np.count_nonzero(known)),
        minimum=float(angle[low]),
        maximum=float(angle[high]),
        mean=float(np.mean(angle[known])),
        range=float(angle[high] - angle[low]),
        range_sigma=float(np.hypot(sigma[low], sigma[high])),
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
