"""One correction of a pose by residuals; a new measurement or constraint is one new file."""

from collections.abc import Iterable
from typing import Protocol

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.manifold import Columns, Rows, difference, displaced, gather, jacobian
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.filtering.correction import normalised
from stereotrack_core.filtering.linearisation import Information, posterior
from stereotrack_core.tracking.state import Belief, Setup

_STEP_LIMIT = 0.5  # radians and metres by which one correction may move a number of the error state


class Residual(Protocol):
    """A measurement of the pose, already paired with what it measures."""

    @property
    def measured(self) -> FloatArray:
        """The vector z (m,)."""

    @property
    def variance(self) -> FloatArray:
        """Diagonal of R (m,)."""

    def predicted(self, frames: PartFrames) -> FloatArray:
        """z_hat (S, m) for stacked poses."""

    def rows(self, frames: PartFrames) -> Rows:
        """The measurement, linearised at one pose."""


class Observation(Protocol):
    """What one sensor saw at one instant; pairs itself anew with every pose."""

    def residuals(self, body: BodyModel, pose: Pose) -> tuple[Residual, ...]:
        """Residuals at a pose; none where nothing was seen."""


def solved(
    joints: tuple[int, ...], prior: Belief, at: Pose, found: Information
) -> tuple[Belief, FloatArray]:
    """Join a prior and what was gathered at a pose; the step (n,) to the result is limited."""
    dx, P = posterior(prior.information, difference(prior.pose, at, joints), found)
    return Belief(displaced(at, np.clip(dx, -_STEP_LIMIT, _STEP_LIMIT), joints), P), dx


def gathered(sources: Iterable[Rows], frames: PartFrames, columns: Columns) -> Information:
    """Normal equations of the rows of all sources, linearised at one pose."""
    total = Information(np.zeros((columns.n, columns.n)), np.zeros(columns.n))
    for rows in sources:
        gather(rows, frames.rotations, frames.origins, columns.first, total.A, total.b)
    return total


def innovation_of(residual: Residual, setup: Setup, predicted: Belief) -> float:
    """Normalised innovation of a measurement at a predicted pose; NaN without any."""
    frames = setup.body.frames(predicted.pose)
    rows = residual.rows(frames)
    H = jacobian(rows, frames, setup.columns)
    spread = np.einsum("mn,mn->m", H @ predicted.P, H)
    return normalised(rows["innovation"], spread + rows["variance"])
