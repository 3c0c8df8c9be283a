"""One frame's clicks, downhill only: Levenberg's and Marquardt's damping on the whole cost.

Linearised again and again without damping, a body that begins far from its clicks is thrown about
and comes to rest anywhere. Here every step must make the cost smaller: of what is expected, of the
clicks, each a mixture of right ones and gross mistakes, and of the limits.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from stereotrack_core.annotation.fit.mistakes import (
    Judgement,
    judged,
    mixture_cost,
    mixture_weight,
)
from stereotrack_core.annotation.fit.movement import shift_sigmas
from stereotrack_core.annotation.fit.residuals import ClickResidual, Clicks
from stereotrack_core.annotation.fit.settings import FitSettings
from stereotrack_core.annotation.fit.state import FitState, Freedom
from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.filtering.linearisation import information
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.residuals.limits import Limit, limit_residuals

_FIRST_DAMPING = 1e-2
_LEAST_DAMPING, _MOST_DAMPING = 1e-5, 1e6
_EASED, _TIGHTENED = 0.2, 5.0
"""Factors on the damping after a step that was taken, and after one that was not."""

_SETTLED = 0.05
"""A step that lowers the cost by less than this is the last one."""

_ROUGHLY = 0.3
"""The same where only the neighbourhood is looked for."""

_FARTHEST = 0.7
"""Radians and metres by which one step may move a number of the state."""

_LIMITS = TrackingParameters()


@dataclass(frozen=True, eq=False)
class Expected:
    """What is expected before any click.

    Attributes
    ----------
    pose : Pose
    sigma : (of_pose,) float64
        How firmly.
    """

    pose: Pose
    sigma: FloatArray


@dataclass(frozen=True, eq=False)
class _Seen:
    """A state and all that is measured at it."""

    state: FitState
    frames: PartFrames
    expected: FloatArray
    clicks: ClickResidual
    residual: FloatArray
    limits: tuple[Limit, ...]
    cost: float


class Descent:
    """Fits one frame's clicks from any pose to begin with.

    Parameters
    ----------
    freedom : Freedom
        Of clicks alone, without the surface's slips.
    settings : FitSettings
    clicks : Clicks
    expected : Expected
    """

    def __init__(
        self, freedom: Freedom, settings: FitSettings, clicks: Clicks, expected: Expected
    ) -> None:
        self._freedom, self._clicks, self._expected = freedom, clicks, expected
        self._mistakes = settings.mistake_share, settings.mistake_spread
        self._prior = np.concatenate([expected.sigma, shift_sigmas(freedom, settings)]) ** -2.0

    def descend(
        self, state: FitState, sigma: FloatArray, steps: int, *, roughly: bool = False
    ) -> tuple[FitState, float]:
        """Go downhill from a state; where that leads, and what it costs.

        Parameters
        ----------
        state : FitState
        sigma : (M,) float64
            Pixels per axis by which right clicks are taken to scatter.
        steps : int
            At most so many are tried.
        roughly : bool
            Without limits, and only until steps are worth little.
        """
        f, damping = self._freedom, _FIRST_DAMPING
        limited, settled = not roughly, _ROUGHLY if roughly else _SETTLED
        here = self._seen(state, sigma, limited=limited)
        normal = self._normal(here, sigma)
        for _ in range(steps):
            A, b = normal
            damped = A + damping * np.diag(np.diagonal(A))
            step = scipy.linalg.solve(damped, b, assume_a="pos", check_finite=False)
            step = step * min(1.0, _FARTHEST / max(float(np.abs(step).max()), 1e-12))
            there = self._seen(f.displaced(here.state, step), sigma, limited=limited)
            gained = here.cost - there.cost
            if gained > 0.0:
                here, damping = there, max(_EASED * damping, _LEAST_DAMPING)
                if gained < settled:
                    break
                normal = self._normal(here, sigma)
            else:
                damping = _TIGHTENED * damping
                if gained > -settled or damping > _MOST_DAMPING:
                    break
        return here.state, here.cost

    def judged(self, state: FitState, sigma: FloatArray) -> tuple[Judgement, FloatArray]:
        """Judge every click by all others, where a descent has come to rest.

        Returns
        -------
        Judgement
        P : (n, n) float64
            Covariance of the error state.
        """
        here = self._seen(state, sigma)
        A, _ = self._normal(here, sigma)
        P = np.asarray(scipy.linalg.inv(A, check_finite=False), dtype=np.float64)
        P = 0.5 * (P + P.T)
        columns = self._freedom.columns
        J = here.clicks.jacobian(here.frames, columns)
        J = J.reshape(len(self._clicks), 2, columns.n)
        weight = mixture_weight(here.residual, sigma, *self._mistakes)
        spread = J @ P @ np.swapaxes(J, 1, 2)
        return judged(here.residual, spread, sigma, weight, *self._mistakes), P

    def _seen(self, state: FitState, sigma: FloatArray, *, limited: bool = True) -> _Seen:
        f = self._freedom
        body = f.body_at(state.offsets)
        frames = body.frames(state.pose)
        stacked = PartFrames(frames.rotations[None], frames.origins[None])
        local = f.own_place(state.offsets)
        clicks = ClickResidual(self._clicks, f, local, np.repeat(sigma**2, 2))
        residual = (clicks.measured - clicks.predicted(stacked)[0]).reshape(-1, 2)
        limits = limit_residuals(body, state.pose, _LIMITS, f.joints) if limited else ()
        away = f.pose_difference(self._expected.pose, state.pose)
        expected = np.concatenate([away, -state.offsets.ravel()])
        cost = float(self._prior @ expected**2) + float(
            mixture_cost(residual, sigma, *self._mistakes).sum()
        )
        for row in limits:
            off = row.measured - row.predicted(stacked)[0]
            cost += float((off**2 / row.variance).sum())
        return _Seen(state, frames, expected, clicks, residual, limits, cost)

    def _normal(self, here: _Seen, sigma: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Normal equations at a state; the clicks weighed as the mixture sees them there."""
        columns, frames = self._freedom.columns, here.frames
        A, b = np.diag(self._prior), self._prior * here.expected
        variance = np.repeat(sigma**2 / mixture_weight(here.residual, sigma, *self._mistakes), 2)
        told = information(here.clicks.jacobian(frames, columns).T, here.residual.ravel(), variance)
        A, b = A + told.A, b + told.b
        stacked = PartFrames(frames.rotations[None], frames.origins[None])
        for row in here.limits:
            off = row.measured - row.predicted(stacked)[0]
            told = information(row.jacobian(frames, columns).T, off, row.variance)
            A, b = A + told.A, b + told.b
        return A, b
