"""Angles made smooth, with their velocities and ranges; errors against a reference.

The low-pass is a Butterworth filter of second order, run forwards and backwards: fourth order and
no lag. Its cut-off is corrected for the two passes (Winter, Biomechanics and Motor Control of Human
Movement, 4th ed., section 2.2.4.4; Robertson and Dowling, doi:10.1016/S1050-6411(03)00080-4), so
that the stated frequency is where both together let through 1 / sqrt(2).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.joint_angles.definitions import (
    ANGLES,
    AngleDefinition,
    wrapped,
)
from stereotrack_core.evaluation.joint_angles.series import JointAngles, stretches
from stereotrack_core.recording.description import Segment

CUT_OFF_HZ = 6.0
"""Usual for voluntary movements of the upper body."""

HIGHEST_SHARE = 0.4
"""Of the frame rate: no cut-off is higher, for no frequency above half of the rate is seen."""

SHORTEST = 5
"""Frames: shorter stretches are neither filtered nor differentiated."""

_PASSES = 2
_CORRECTION = (2.0 ** (1.0 / _PASSES) - 1.0) ** 0.25


@dataclass(frozen=True, eq=False)
class Motion:
    """Smooth angles and their velocities; F frames, A angles in the order of :data:`ANGLES`.

    NaN where the angle is not known, or in a stretch of fewer than :data:`SHORTEST` frames.
    """

    angle: FloatArray
    """(F, A), radians."""
    velocity: FloatArray
    """(F, A), radians per second. By central differences of the smooth angle; at both ends of a
    stretch one-sided."""
    cut_off: float
    """Hertz. What was used."""
    fps: float

    @property
    def words(self) -> str:
        """How it was made, in one sentence."""
        limit = HIGHEST_SHARE * self.fps
        limited = (
            f", the highest possible at {self.fps:g} frames per second"
            if self.cut_off >= limit * (1.0 - 1e-9)
            else ""
        )
        return (
            "Smoothed with a zero-phase fourth-order Butterworth low-pass filter, cut-off "
            f"{self.cut_off:g} Hz{limited}. Gaps are not bridged."
        )


def motion_of(angles: JointAngles, fps: float) -> Motion:
    """Filter and differentiate angles, stretch by stretch of successive frames.

    The cut-off is :data:`HIGHEST_SHARE` of `fps` (frame sets per second) where it would be higher.
    At 10 frames per second that is 4 Hz, and the central differences let through 64 % of a movement
    of 2.5 Hz. Raises InputError for a frame rate that is not positive.
    """
    if not (np.isfinite(fps) and fps > 0):
        raise InputError(
            f"{fps:g} is not a frame rate",
            where="--fps",
            remedy="Give a number of frames per second above 0.",
        )
    cut_off = min(CUT_OFF_HZ, HIGHEST_SHARE * fps)
    smooth, velocity = (np.full(angles.angle.shape, np.nan) for _ in range(2))
    for k in range(len(ANGLES)):
        values = angles.angle[:, k]
        for stretch in stretches(angles.frame, np.isfinite(values)):
            if stretch.stop - stretch.start < SHORTEST:
                continue
            filtered = low_pass(values[stretch], fps, cut_off)
            smooth[stretch, k] = filtered
            velocity[stretch, k] = np.gradient(filtered, 1.0 / fps, edge_order=2)
    return Motion(smooth, velocity, cut_off, fps)


def low_pass(values: FloatArray, fps: float, cut_off: float) -> FloatArray:
    """Filter values (n, ...) of successive frames along their first axis.

    Before the first and after the last value they are continued by point reflection, as far as
    there are values to reflect.
    """
    from scipy import signal  # it loads all of scipy.stats

    warped = np.tan(np.pi * cut_off / fps) / _CORRECTION
    section = signal.butter(2, 2.0 * np.arctan(warped) / np.pi, output="sos")
    wanted = max(24, round(6.0 * fps / cut_off))
    result: FloatArray = signal.sosfiltfilt(
        section, values, axis=0, padtype="odd", padlen=min(wanted, len(values) - 1)
    )
    return result


_QUANTITIES = ("deg", "sigma_deg", "smooth_deg", "velocity_deg_s")
_DIGITS = 4


def frame_columns() -> tuple[str, ...]:
    """Headings: ``frame``, ``seconds``, then four for every angle."""
    names = [f"{angle.name}_{quantity}" for angle in ANGLES for quantity in _QUANTITIES]
    return ("frame", "seconds", *names)


def frame_rows(angles: JointAngles, motion: Motion) -> list[list[str | float | int]]:
    """Rows under :func:`frame_columns`; what is not known is empty.

    Seconds are those since frame 0 of the recording.
    """
    stacked = np.degrees(
        np.stack([angles.angle, angles.sigma, motion.angle, motion.velocity], axis=-1)
    ).reshape(len(angles.frame), len(ANGLES) * len(_QUANTITIES))
    rows: list[list[str | float | int]] = []
    for frame, values in zip(angles.frame.tolist(), stacked.round(_DIGITS).tolist(), strict=True):
        cells = ["" if np.isnan(value) else value for value in values]
        rows.append([frame, round(frame / motion.fps, 6), *cells])
    return rows


WHOLE = "all"
"""Name of the stretch that is the whole recording."""


@dataclass(frozen=True)
class AngleRange:
    """How one angle moves in a stretch; radians, NaN where nothing is known."""

    angle: AngleDefinition
    frames: int
    """Frames in which the smooth angle is known."""
    minimum: float
    maximum: float
    range: float
    range_sigma: float
    """Standard deviation of the range, errors at both ends taken for independent."""
    mean: float
    """`minimum`, `maximum` and `mean`: of the smooth angle."""
    sigma: float
    """Root mean square of the angle's standard deviation."""
    peak_velocity: float
    """Radians per second. Largest speed in either direction."""

    def degrees(self) -> dict[str, float]:
        """Everything but the frames by its name, in degrees and degrees per second."""
        return _degrees(self, "minimum", "peak_velocity")


@dataclass(frozen=True)
class StretchMotion:
    """Ranges of motion of one stretch of frames."""

    name: str
    """The segment, or ``"all"``."""
    first: int
    end: int
    """`first` and `end`: frames of it that there are, half-open; as the segment has them where
    there is none."""
    ranges: tuple[AngleRange, ...]
    """In the order of :data:`ANGLES`."""

    def of(self, name: str) -> AngleRange:
        """The range of an angle by its name; KeyError where there is none."""
        return {one.angle.name: one for one in self.ranges}[name]


def range_of_motion(
    angles: JointAngles, motion: Motion, segments: Sequence[Segment] = ()
) -> tuple[StretchMotion, ...]:
    """Ranges of motion of the smooth angles: the whole first, then every segment.

    Standard deviations are those of the angles before.
    """
    first = int(angles.frame[0]) if len(angles.frame) else 0
    end = int(angles.frame[-1]) + 1 if len(angles.frame) else 0
    whole = Segment(WHOLE, first, end)
    return tuple(_stretch_motion(angles, motion, stretch) for stretch in (whole, *segments))


def _stretch_motion(angles: JointAngles, motion: Motion, stretch: Segment) -> StretchMotion:
    """Ranges of motion in one stretch of frames."""
    inside = (angles.frame >= stretch.first) & (angles.frame < stretch.end)
    ranges = tuple(
        _range(
            definition,
            motion.angle[inside, k],
            angles.sigma[inside, k],
            motion.velocity[inside, k],
        )
        for k, definition in enumerate(ANGLES)
    )
    first, end = stretch.first, stretch.end
    if inside.any():
        first, end = int(angles.frame[inside][0]), int(angles.frame[inside][-1]) + 1
    return StretchMotion(stretch.name, first, end, ranges)


def _range(
    definition: AngleDefinition,
    angle: FloatArray,
    sigma: FloatArray,
    velocity: FloatArray,
) -> AngleRange:
    known = np.isfinite(angle)
    if not known.any():
        return AngleRange(definition, 0, *[math.nan] * 7)
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
    )


@dataclass(frozen=True)
class AngleError:
    """Errors of one angle over frames; radians, NaN where nothing could be compared."""

    angle: AngleDefinition
    frames: int
    """Frames in which both know the angle."""
    mean_error: float
    median: float
    rms: float
    p95: float
    """`mean_error`, `median`, `rms` and `p95`: mean error with its sign; median, root mean square
    and 95th percentile of its size."""
    stated_sigma: float
    """Root mean square of what is stated."""
    within_two_sigma: float
    """Share (0 to 1) of the errors within two stated standard deviations; NaN where none is stated.
    Of a normal distribution 0.95 are."""

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
    return tuple(_error_of(one, errors[:, k], sigma[:, k]) for k, one in enumerate(ANGLES))


def _error_of(definition: AngleDefinition, error: FloatArray, sigma: FloatArray) -> AngleError:
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
