"""One correction of a pose by residuals; a new measurement or constraint is one new file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeAlias

import numpy as np
import scipy

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.manifold import Columns, difference, displaced
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.filtering.correction import normalised
from stereotrack_core.filtering.linearisation import Information, information, posterior
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


Sensor: TypeAlias = Callable[[Cloud], Observation]
"""A source of measurements beside the cloud's points: it takes from one instant what does not
depend on the pose."""


def solved(
    joints: tuple[int, ...], prior: Belief, at: Pose, found: Information
) -> tuple[Belief, FloatArray]:
    """Join a prior and what was gathered at a pose; the step (n,) to the result is limited."""
    P0_inverse: FloatArray = scipy.linalg.inv(prior.P)
    dx, P = posterior(P0_inverse, difference(prior.pose, at, joints), found)
    return Belief(displaced(at, np.clip(dx, -_STEP_LIMIT, _STEP_LIMIT), joints), P), dx


@dataclass(frozen=True, eq=False)
class Line:
    """A residual, linearised at one pose: z - z_hat = H dx + e."""

    residual: Residual
    nu: FloatArray
    """(m,). Innovation z - z_hat."""
    H: FloatArray
    """(m, n). Jacobian by the error state."""
    R: FloatArray
    """(m,). Variances of e."""


def linearise(
    residuals: tuple[Residual, ...], body: BodyModel, pose: Pose, columns: Columns
) -> list[Line]:
    """Linearise all residuals that have rows at a pose, by their derivatives."""
    frames = body.frames(pose)
    stacked = PartFrames(frames.rotations[None], frames.origins[None])
    return [
        Line(
            residual,
            residual.measured - residual.predicted(stacked)[0],
            residual.jacobian(frames, columns),
            residual.variance,
        )
        for residual in residuals
        if len(residual.variance)
    ]


def information_of(lines: Sequence[Line], n: int) -> Information:
    """What lines say together about an error state of n numbers."""
    total = Information(np.zeros((n, n)), np.zeros(n))
    for line in lines:
        total += information(line.H.T, line.nu, line.R)
    return total


def gathered(
    residuals: tuple[Residual, ...], body: BodyModel, pose: Pose, columns: Columns
) -> Information:
    """Linearise all residuals at a pose by their derivatives and gather their information."""
    return information_of(linearise(residuals, body, pose, columns), columns.n)


def innovation_of(residual: Residual, setup: Setup, predicted: Belief) -> float:
    """Normalised innovation of a measurement at a predicted pose; NaN without any."""
    lines = linearise((residual,), setup.body, predicted.pose, setup.columns)
    if not lines:
        return float("nan")
    H = lines[0].H
    return normalised(lines[0].nu, np.einsum("mn,mn->m", H @ predicted.P, H) + lines[0].R)
