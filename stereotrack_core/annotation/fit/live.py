"""One frame fitted by itself, while somebody clicks.

The clicks alone are fitted first, from a few poses, from a wide scatter of the clicks to the one
that they state or really have. Without damping a body far from its clicks is thrown about; with
Levenberg's and Marquardt's every step lowers the cost. Measured points help to choose among the
poses, and are then fitted together with the clicks.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.fit.context import (
    FitContext,
    pose_at,
    standing,
    triangulated,
    watched_place,
)
from stereotrack_core.annotation.fit.residuals import (
    ClickResidual,
    Clicks,
    Judgement,
    judged,
    mixture_cost,
    mixture_weight,
    scatter,
)
from stereotrack_core.annotation.fit.results import FrameFit, frame_fit
from stereotrack_core.annotation.fit.state import (
    FitSettings,
    FitState,
    Freedom,
    pose_sigmas,
    shift_sigmas,
)
from stereotrack_core.annotation.fit.stretch import Fitted, FrameData, MeasuredDepth, depth_cost
from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.manifold import Rows
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.body.posing import TRUNK
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.filtering.linearisation import information
from stereotrack_core.tracking.correction import gathered
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.residuals.limits import limit_rows

_FIRST_DAMPING = 1e-2
_LEAST_DAMPING, _MOST_DAMPING = 1e-5, 1e6
_EASED, _TIGHTENED = 0.2, 5.0  # factors on the damping after a step that was taken, or was not
_SETTLED = 0.05  # A step that lowers the cost by less than this is the last one
_ROUGHLY = 0.3  # the same where only the neighbourhood is looked for
_FARTHEST = 0.7  # radians and metres by which one step may move a number of the state
_LIMITS = TrackingParameters()


@dataclass(frozen=True, eq=False)
class Expected:
    """A pose that is expected before any click, and how firmly: sigma (of_pose,)."""

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
    limits: Rows
    cost: float


class Descent:
    """Fits one frame's clicks from any pose to begin with; `freedom` is that of clicks alone."""

    def __init__(
        self, freedom: Freedom, settings: FitSettings, clicks: Clicks, expected: Expected
    ) -> None:
        self.expected = expected
        self._freedom, self._clicks = freedom, clicks
        self._prior = np.concatenate([expected.sigma, shift_sigmas(freedom, settings)]) ** -2.0

    def descend(
        self, state: FitState, sigma: FloatArray, steps: int, *, roughly: bool = False
    ) -> tuple[FitState, float]:
        """Go downhill from a state, at most so many steps; where that leads, and its cost.

        `sigma` (M,): pixels of the clicks' scatter. Roughly is without limits, until steps are
        worth little.
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
        """Judge each click by all others where a descent has come to rest; also P there."""
        here = self._seen(state, sigma)
        A, _ = self._normal(here, sigma)
        P = np.asarray(scipy.linalg.inv(A, check_finite=False), dtype=np.float64)
        P = 0.5 * (P + P.T)
        columns = self._freedom.columns
        J = here.clicks.jacobian(here.frames)
        J = J.reshape(len(self._clicks), 2, columns.n)
        weight = mixture_weight(here.residual, sigma, self._clicks.share)
        spread = J @ P @ np.swapaxes(J, 1, 2)
        return judged(here.residual, spread, sigma, weight, self._clicks.share), P

    def _seen(self, state: FitState, sigma: FloatArray, *, limited: bool = True) -> _Seen:
        f = self._freedom
        body = f.body_at(state.offsets)
        frames = body.frames(state.pose)
        local = f.own_place(state.offsets)
        clicks = ClickResidual(self._clicks, f, local, np.repeat(sigma**2, 2))
        residual = clicks.missed(frames)
        limits = limit_rows(body, state.pose, _LIMITS, f.joints)[: None if limited else 0]
        away = f.pose_difference(self.expected.pose, state.pose)
        expected = np.concatenate([away, -state.offsets.ravel()])
        cost = float(self._prior @ expected**2) + float(
            mixture_cost(residual, sigma, self._clicks.share).sum()
        )
        cost += float((limits["innovation"] ** 2 / limits["variance"]).sum())
        return _Seen(state, frames, expected, clicks, residual, limits, cost)

    def _normal(self, here: _Seen, sigma: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Normal equations at a state; the clicks weighed as the mixture sees them there."""
        columns, frames = self._freedom.columns, here.frames
        A, b = np.diag(self._prior), self._prior * here.expected
        weight = mixture_weight(here.residual, sigma, self._clicks.share)
        variance = np.repeat(sigma**2 / weight, 2)
        told = information(here.clicks.jacobian(frames).T, here.residual.ravel(), variance)
        told += gathered((here.limits,), frames, columns)
        return A + told.A, b + told.b


_WIDEST = 40.0  # pixels that clicks scatter at least, from poses to begin with that are far off
_NARROWER = (20.0, 10.0, 5.0, 0.0)  # the same, step by step, once a pose is near
_STEPS = 12  # steps downhill at most, at each scatter
_KEPT = 2  # poses that are followed beyond the widest scatter
_MORE_THAN_STATED = 1.5  # factor from which clicks are believed to scatter more than stated
_ROUNDS = 5  # rounds with measured points
_USUAL = (1.0, 60.0, 50.0)  # how far a body may be from the usual pose: m; deg of torso, of a joint
_ENOUGH = 3  # landmarks of the trunk that tell how it is turned
_TOP = 95.0  # percentile of the measured points' heights at which the head is


@dataclass(frozen=True, eq=False)
class _Way:
    """A descent, how far it has come, and what that costs."""

    descent: Descent
    state: FitState
    cost: float


def fitted_frame(
    context: FitContext, measurements: Sequence[Click], cloud: Cloud | MeasuredDepth | None
) -> FrameFit:
    """Fit one frame; see :meth:`ClickFit.frame`."""
    data, f = context.data(measurements, cloud), context.by_clicks.freedom
    points = triangulated(data.clicks, len(context.whole.landmarks))
    ways = []
    for usual in _usual_poses(context, points, data):
        expected = Expected(usual, pose_sigmas(f, *_USUAL))
        begin = f.still(pose_at(points, context.body, context.whole, usual))
        ways.append(_Way(Descent(f, context.settings, data.clicks, expected), begin, np.inf))
    for least, kept in ((_WIDEST, _KEPT), (_NARROWER[0], 1)):
        sigma = np.maximum(data.clicks.sigma, least)
        ways = [_further(way, sigma, roughly=len(ways) > 1) for way in ways]
        costs = [way.cost for way in ways]
        if data.depth is not None:
            seen = data.depth.points
            costs = [w.cost + depth_cost(context.by_depth, seen, w.state.pose) for w in ways]
        ways = [ways[i] for i in np.argsort(costs, kind="stable")[:kept]]
    best, sigma = _narrowed(ways[0], data.clicks.sigma)
    factor = float(np.max(sigma / data.clicks.sigma, initial=1.0))
    found = _finished(context, data, best, sigma)
    stretch = context.by_clicks if data.depth is None else context.by_depth
    return frame_fit(stretch.freedom, found, context, measurements, factor)


def _further(way: _Way, sigma: FloatArray, *, roughly: bool = False) -> _Way:
    return _Way(way.descent, *way.descent.descend(way.state, sigma, _STEPS, roughly=roughly))


def _narrowed(way: _Way, stated: FloatArray) -> tuple[_Way, FloatArray]:
    """Follow a way to the scatter that the clicks state, or to the one that they show."""
    for least in _NARROWER:
        sigma = np.maximum(stated, least)
        if least < _NARROWER[0]:
            way = _further(way, sigma)
        last = bool((sigma == stated).all())
        shown = scatter(way.descent.judged(way.state, sigma)[0])
        if shown > (_MORE_THAN_STATED if last else 1.0):
            sigma = shown * sigma
            return _further(way, sigma), sigma
        if last:
            break
    return way, sigma


def _finished(context: FitContext, data: FrameData, way: _Way, sigma: FloatArray) -> Fitted:
    """The final fit; with measured points, fitted once more together with them."""
    if data.depth is None:
        judgement, P = way.descent.judged(way.state, sigma)
        return Fitted([way.state], P[None], [judgement])
    stretch, expected = context.by_depth, way.descent.expected
    data = replace(data, clicks=replace(data.clicks, sigma=sigma))
    firmly = np.full(stretch.freedom.of_pose, expected.sigma[-1])
    firmly[: len(expected.sigma)] = expected.sigma
    begin = replace(stretch.freedom.still(way.state.pose), offsets=way.state.offsets)
    return stretch.fit_one(data, begin, expected.pose, firmly, range(_ROUNDS))


def _usual_poses(context: FitContext, points: FloatArray, data: FrameData) -> list[Pose]:
    """Poses to begin from: one where the trunk shows how it is turned, else four ways round."""
    if not len(data.clicks) and data.depth is None:
        return [context.usual]
    place, names = watched_place(context.cameras), context.whole.names
    if data.depth is not None and len(data.depth.points):  # under the top of the measured points
        seen, lengths = data.depth.points, context.body.skeleton.proportions
        below = 0.5 * lengths.torso_length + lengths.shoulder_to_head
        top = float(np.percentile(seen[:, 2], _TOP))
        place = np.append(np.median(seen[:, :2], axis=0), top - below)
    yaws = 0.5 * np.pi * np.arange(4)
    if np.isfinite(points[[names.index(name) for name in TRUNK]]).all(axis=1).sum() >= _ENOUGH:
        x = pose_at(points, context.body, context.whole, context.usual).torso[:, 0]
        yaws = np.arctan2(x[1:2], x[:1])
    return [standing(context.body, place, float(yaw)) for yaw in yaws]
