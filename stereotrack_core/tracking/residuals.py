"""What measurements and constraints have in common: a new one is one new file."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.manifold import displaced
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.filtering.linearisation import (
    Information,
    information,
    linearised,
    unwhitened,
)
from stereotrack_core.filtering.sigma_points import SigmaWeights


class Residual(Protocol):
    """A measurement of the pose, already paired with what it measures."""

    @property
    def measured(self) -> FloatArray:
        """The vector z (m,)."""
        ...

    @property
    def variance(self) -> FloatArray:
        """Diagonal of R (m,)."""
        ...

    def predicted(self, frames: PartFrames) -> FloatArray:
        """z_hat (S, m) for stacked poses."""
        ...


def gathered(
    residuals: tuple[Residual, ...],
    body: BodyModel,
    pose: Pose,
    P: FloatArray,
    weights: SigmaWeights,
    joints: tuple[int, ...],
) -> Information:
    """Linearise all residuals by the same sigma points and gather their information.

    The linearisation's own error is added to the noise; without it P is too confident.
    """
    L = np.asarray(np.linalg.cholesky(P), dtype=np.float64)
    root = weights.spread * L.T
    dX = np.concatenate([np.zeros((1, len(P))), root, -root])
    frames = body.frames(displaced(pose, dX, joints))
    total = Information(np.zeros_like(P), np.zeros(len(P)))
    for residual in residuals:
        if len(residual.variance):
            line = linearised(residual.predicted(frames), weights, about="centre")
            nu, R = residual.measured - line.mean, residual.variance + line.spread
            total += information(line.D, nu, R)
    return unwhitened(total, L)
