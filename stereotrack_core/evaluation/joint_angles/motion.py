"""Angles made smooth, with their velocities and accelerations.

The low-pass is a Butterworth filter of second order, run forwards and backwards: fourth order and
no lag. Its cut-off is corrected for the two passes (Winter, Biomechanics and Motor Control of Human
Movement, 4th ed., section 2.2.4.4; Robertson and Dowling, doi:10.1016/S1050-6411(03)00080-4), so
that the stated frequency is where both together let through 1 / sqrt(2).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import signal

from stereotrack_core.arrays import FloatArray
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.joint_angles.definitions import ANGLES
from stereotrack_core.evaluation.joint_angles.series import JointAngles, stretches

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
    """Smooth angles and their derivatives; F frames, A angles in the order of :data:`ANGLES`.

    NaN where the angle is not known, or in a stretch of fewer than :data:`SHORTEST` frames.

    Attributes
    ----------
    angle : (F, A) float64, radians
    velocity : (F, A) float64, radians per second
        By central differences of the smooth angle; at both ends of a stretch one-sided.
    acceleration : (F, A) float64, radians per square second
        Second differences; NaN at both ends of a stretch.
    velocity_sigma, acceleration_sigma : (F, A) float64
        Standard deviations if errors of different frames are independent; those that are alike
        in successive frames make the derivatives surer than that.
    cut_off : float, hertz
        What was used.
    """

    angle: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    velocity_sigma: FloatArray
    acceleration_sigma: FloatArray
    cut_off: float
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


def motion_of(angles: JointAngles, fps: float, cut_off: float = CUT_OFF_HZ) -> Motion:
    """Filter and differentiate angles, stretch by stretch of successive frames.

    Raises InputError for a cut-off or a frame rate that is not positive.

    Parameters
    ----------
    fps : float
        Frame sets per second.
    cut_off : float, hertz
        Taken down to :data:`HIGHEST_SHARE` of `fps` where it is higher. At 10 frames per second
        that is 4 Hz, and the central differences let through 64 % of a movement of 2.5 Hz.
    """
    _check(fps, cut_off)
    used = min(cut_off, HIGHEST_SHARE * fps)
    shape = angles.angle.shape
    smooth, velocity, acceleration, v_sigma, a_sigma = (np.full(shape, np.nan) for _ in range(5))
    for k in range(len(ANGLES)):
        values = angles.angle[:, k]
        for stretch in stretches(angles.frame, np.isfinite(values)):
            n = stretch.stop - stretch.start
            if n < SHORTEST:
                continue
            filtered = low_pass(values[stretch], fps, used)
            smooth[stretch, k] = filtered
            velocity[stretch, k] = _velocity(filtered, fps)
            acceleration[stretch, k] = _acceleration(filtered, fps)
            variance = np.square(angles.sigma[stretch, k])
            v_sigma[stretch, k], a_sigma[stretch, k] = _derivative_sigmas(variance, fps, used)
    return Motion(smooth, velocity, acceleration, v_sigma, a_sigma, used, fps)


def low_pass(values: FloatArray, fps: float, cut_off: float) -> FloatArray:
    """Filter values (n, ...) of successive frames along their first axis.

    Before the first and after the last value they are continued by point reflection, as far as
    there are values to reflect.
    """
    warped = np.tan(np.pi * cut_off / fps) / _CORRECTION
    section = signal.butter(2, 2.0 * np.arctan(warped) / np.pi, output="sos")
    wanted = max(24, round(6.0 * fps / cut_off))
    result: FloatArray = signal.sosfiltfilt(
        section, values, axis=0, padtype="odd", padlen=min(wanted, len(values) - 1)
    )
    return result


def _check(fps: float, cut_off: float) -> None:
    if not (np.isfinite(fps) and fps > 0):
        raise InputError(
            f"{fps:g} is not a frame rate",
            where="--fps",
            remedy="Give a number of frames per second above 0.",
        )
    if not (np.isfinite(cut_off) and cut_off > 0):
        raise InputError(
            f"{cut_off:g} Hz is not a cut-off frequency",
            where="--cutoff",
            remedy="Give a frequency above 0 Hz; 6 is usual.",
        )


def _velocity(values: FloatArray, fps: float) -> FloatArray:
    result: FloatArray = np.gradient(values, 1.0 / fps, axis=0, edge_order=2)
    return result


def _acceleration(values: FloatArray, fps: float) -> FloatArray:
    result: FloatArray = np.full_like(values, np.nan)
    result[1:-1] = np.diff(values, n=2, axis=0) * fps**2
    return result


def _derivative_sigmas(
    variance: FloatArray, fps: float, cut_off: float
) -> tuple[FloatArray, FloatArray]:
    """Standard deviations (n,) of both derivatives by the variances (n,) of independent angles."""
    longest = 2 * max(32, 8 * int(np.ceil(fps / cut_off)))
    smooth = low_pass(np.eye(min(len(variance), longest)), fps, cut_off)
    velocity = _through(np.square(_velocity(smooth, fps)), variance)
    acceleration = _through(np.square(_acceleration(smooth, fps)), variance)
    return np.sqrt(velocity), np.sqrt(acceleration)


def _through(weights: FloatArray, variance: FloatArray) -> FloatArray:
    """Variances (n,) after a linear filter, given its squared responses on at most n frames.

    The responses reach less than a quarter of `weights` (m, m) far: where n is larger than m,
    those of the middle hold for all frames that are not near an end.
    """
    n, m = len(variance), len(weights)
    if n == m:
        result: FloatArray = weights @ variance
        return result
    middle = np.convolve(variance, weights[m // 2][::-1], mode="full")
    result = middle[m - 1 - m // 2 :][:n].copy()
    half = m // 2
    result[:half] = (weights @ variance[:m])[:half]
    result[-half:] = (weights @ variance[-m:])[-half:]
    return result


_QUANTITIES = (
    "deg", "sigma_deg", "smooth_deg", "velocity_deg_s", "velocity_sigma_deg_s",
    "acceleration_deg_s2", "acceleration_sigma_deg_s2",
)  # fmt: skip
_DIGITS = 4


def frame_columns() -> tuple[str, ...]:
    """Headings: ``frame``, ``seconds``, then seven for every angle."""
    names = [f"{angle.name}_{quantity}" for angle in ANGLES for quantity in _QUANTITIES]
    return ("frame", "seconds", *names)


def frame_rows(angles: JointAngles, motion: Motion) -> list[list[str | float | int]]:
    """Rows under :func:`frame_columns`; what is not known is empty.

    Seconds are those since frame 0 of the recording.
    """
    stacked = np.degrees(
        np.stack(
            [
                angles.angle, angles.sigma, motion.angle, motion.velocity, motion.velocity_sigma,
                motion.acceleration, motion.acceleration_sigma,
            ],
            axis=-1,
        )
    ).reshape(len(angles.frame), len(ANGLES) * len(_QUANTITIES))  # fmt: skip
    rows: list[list[str | float | int]] = []
    for frame, values in zip(angles.frame.tolist(), stacked.round(_DIGITS).tolist(), strict=True):
        cells = ["" if np.isnan(value) else value for value in values]
        rows.append([frame, round(frame / motion.fps, 6), *cells])
    return rows
