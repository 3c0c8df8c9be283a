"""How much a body may move from one frame set to the next (3.2.1), and how many there are."""

from __future__ import annotations

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.skeleton import CLAVICLES
from stereotrack_core.tracking.parameters import TrackingParameters

_STATED_AT = 10.0
"""Frame sets per second for which the parameters state the standard deviations."""


def process_noise(
    parameters: TrackingParameters, joints: tuple[int, ...], fps: float
) -> FloatArray:
    """Diagonal covariance Q (6 + 2 J, 6 + 2 J) of one step: a symmetric random walk.

    Parameters
    ----------
    parameters : TrackingParameters
    joints : tuple of int
        Parts whose two numbers follow three of position and three of rotation in the state.
    fps : float
        Frame sets per second; variances grow with the time between them.
    """
    p = parameters
    turns = [p.sigma_girdle if joint in CLAVICLES else p.sigma_joint for joint in joints]
    rotations = np.radians([p.sigma_rotation] * 3 + [turn for turn in turns for _ in range(2)])
    sigma = np.concatenate([np.full(3, p.sigma_position), rotations])
    return np.diag(sigma**2 * _STATED_AT / fps)


def elapsed(since: float | None, time: float) -> float:
    """Frames between two times, never negative: a random walk is alike forwards and backwards.

    Parameters
    ----------
    since : float or None
        In frames; where it is not known, the frame before `time`.
    time : float
        In frames.
    """
    return 1.0 if since is None else abs(time - since)


def time_array(time: float | None) -> FloatArray:
    """A time in frames as an array () to be kept; NaN where it is not known."""
    return np.array(np.nan if time is None else time, dtype=np.float64)


def time_in(array: FloatArray) -> float | None:
    """The time that :func:`time_array` was given."""
    return None if np.isnan(array) else float(array)
