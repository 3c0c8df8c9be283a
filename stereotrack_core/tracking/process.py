"""How much a body may move from one frame set to the next (3.2.1)."""

from __future__ import annotations

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.tracking.parameters import TrackingParameters

_STATED_AT = 10.0
"""Frame sets per second for which the parameters state the standard deviations."""


def process_noise(parameters: TrackingParameters, n: int, fps: float) -> FloatArray:
    """Diagonal covariance Q (n, n) of one step: a symmetric random walk.

    Parameters
    ----------
    parameters : TrackingParameters
    n : int
        States: three of position, three of rotation, the rest joints.
    fps : float
        Frame sets per second; variances grow with the time between them.
    """
    joint, rotation = np.radians(parameters.sigma_joint), np.radians(parameters.sigma_rotation)
    sigma = np.full(n, joint)
    sigma[:3], sigma[3:6] = parameters.sigma_position, rotation
    return np.diag(sigma**2 * _STATED_AT / fps)
