"""One correction of a pose by residuals; a new measurement or constraint is one new file."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import scipy.linalg

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.jacobian import Columns
from stereotrack_core.body.manifold import difference, displaced
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.filtering.correction import normalised
from stereotrack_core.filtering.linearisation import (
    Information,
    information,
    linearised,
    posterior,
    unwhitened,
)
from stereotrack_core.filtering.sigma_points import SigmaWeights
from stereotrack_core.tracking.state import Belief, Setup

_STEP_LIMIT = 0.5
"""Radians and metres by which one correction may move a number of the error state."""


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

    def jacobian(self, frames: PartFrames, columns: Columns) -> FloatArray:
        """Derivatives (m, n) of the prediction by the error state, at one pose."""
        ...

    def predicted(self, frames: PartFrames) -> FloatArray:
        """z_hat (S, m) for stacked poses."""
        ...


class Observation(Protocol):
    """What one sensor saw at one instant; pairs itself anew with every pose."""

    def residuals(self, body: BodyModel, pose: Pose) -> tuple[Residual, ...]:
        """Residuals at a pose; none where nothing was seen."""
        ...


class Sensor(Protocol):
    """A source of measurements beside the cloud's points: outlines, detected hands."""

    def observe(self, cloud: Cloud) -> Observation:
        """Take from one instant what does not depend on the pose."""
        ...


def solved(
    joints: tuple[int, ...], prior: Belief, at: Pose, found: Information
) -> tuple[Belief, FloatArray]:
    """Join a prior and what was gathered at a pose; the step (n,) to the result is limited."""
    P0_inverse: FloatArray = scipy.linalg.inv(prior.P)
    dx, P = posterior(P0_inverse, difference(prior.pose, at, joints), found)
    return Belief(displaced(at, np.clip(dx, -_STEP_LIMIT, _STEP_LIMIT), joints), P), dx


def gathered(
    residuals: tuple[Residual, ...], body: BodyModel, pose: Pose, columns: Columns
) -> Information:
    """Linearise all residuals at a pose by their derivatives and gather their information."""
    frames = body.frames(pose)
    stacked = PartFrames(frames.rotations[None], frames.origins[None])
    total = Information(np.zeros((columns.n, columns.n)), np.zeros(columns.n))
    for residual in residuals:
        if len(residual.variance):
            nu = residual.measured - residual.predicted(stacked)[0]
            J = residual.jacobian(frames, columns)
            total += information(J.T, nu, residual.variance)
    return total


def innovation_of(residual: Residual, setup: Setup, predicted: Belief) -> float:
    """Normalised innovation of a measurement at a predicted pose."""
    frames = setup.body.frames(predicted.pose)
    nu = (
        residual.measured
        - residual.predicted(PartFrames(frames.rotations[None], frames.origins[None]))[0]
    )
    H = residual.jacobian(frames, setup.columns)
    return normalised(nu, np.einsum("mn,mn->m", H @ predicted.P, H) + residual.variance)


def gathered_by_sigma_points(
    residuals: tuple[Residual, ...],
    body: BodyModel,
    pose: Pose,
    P: FloatArray,
    weights: SigmaWeights,
    joints: tuple[int, ...],
) -> Information:
    """Linearise all residuals by the same sigma points of the posterior (docs/method.md 4.4).

    The linearisation's own error is added to the noise; without it P is too confident.
    """
    L: FloatArray = scipy.linalg.cholesky(P, lower=True)
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
