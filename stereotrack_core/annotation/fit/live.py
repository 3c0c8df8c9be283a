"""One frame fitted by itself, while somebody clicks.

The clicks alone are fitted first, downhill from a few poses to begin with, from a wide scatter of
the clicks to the one that they state, or to the one that they really have where that is larger.
Measured points help to choose among the poses that are left, and are then fitted together with the
clicks.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from stereotrack_core.annotation.fit.context import FitContext
from stereotrack_core.annotation.fit.depth import MeasuredDepth
from stereotrack_core.annotation.fit.descent import Descent, Expected
from stereotrack_core.annotation.fit.measurement import ClickMeasurement
from stereotrack_core.annotation.fit.mistakes import scatter
from stereotrack_core.annotation.fit.movement import pose_sigmas
from stereotrack_core.annotation.fit.report import (
    exact_residuals,
    reported,
    used_cameras,
    words,
)
from stereotrack_core.annotation.fit.results import FrameFit
from stereotrack_core.annotation.fit.start import (
    TRUNK,
    pose_at,
    standing,
    triangulated,
    watched_place,
)
from stereotrack_core.annotation.fit.state import FitState, Freedom
from stereotrack_core.annotation.fit.stretch import Fitted, FrameData, depth_cost
from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.pose import Pose
from stereotrack_core.depth.cloud import Cloud

_WIDEST = 40.0
"""Pixels that clicks are taken to scatter at least, from poses to begin with that are far off."""

_NARROWER = (20.0, 10.0, 5.0, 0.0)
"""The same, step by step, once a pose is near."""

_STEPS = 12
"""Steps downhill at most, at each scatter."""

_KEPT = 2
"""Poses that are followed beyond the widest scatter."""

_MORE_THAN_STATED = 1.5
"""Factor on their stated scatter from which clicks are believed to scatter more."""

_ROUNDS = 5
"""Rounds with measured points."""

_USUAL = (1.0, 60.0, 50.0)
"""How far a body may be from the usual pose: metres; degrees of the torso, of a joint."""

_NEARBY = (0.2, 30.0, 40.0)
"""How far it may be from a pose nearby."""

_ENOUGH = 3
"""Landmarks of the trunk that tell how it is turned."""

_TOP = 95.0
"""Percentile of the measured points' heights at which the head is."""


@dataclasses.dataclass(frozen=True, eq=False)
class _Way:
    """A descent, how far it has come, and what that costs."""

    descent: Descent
    state: FitState
    expected: Expected
    cost: float


def fitted_frame(
    context: FitContext,
    measurements: Sequence[ClickMeasurement],
    cloud: Cloud | MeasuredDepth | None,
    start: Pose | None,
) -> FrameFit:
    """Fit one frame; see :meth:`ClickFit.frame`."""
    data = context.data(measurements, cloud)
    ways = _ways(context, data, start)
    sigma = np.maximum(data.clicks.sigma, _WIDEST)
    ways = [_further(way, sigma, roughly=len(ways) > 1) for way in ways]
    ways = sorted(ways, key=lambda way: way.cost + _missed(context, data, way.state.pose))[:_KEPT]
    sigma = np.maximum(data.clicks.sigma, _NARROWER[0])
    ways = [_further(way, sigma, roughly=len(ways) > 1) for way in ways]
    best = min(ways, key=lambda way: way.cost + _missed(context, data, way.state.pose))
    best, sigma = _narrowed(best, data.clicks.sigma)
    factor = float(np.max(sigma / data.clicks.sigma, initial=1.0))
    found = _finished(context, data, best, sigma)
    freedom = (context.by_clicks if data.depth is None else context.by_depth).freedom
    return _as_frame(context, freedom, measurements, found, factor)


def _ways(context: FitContext, data: FrameData, start: Pose | None) -> list[_Way]:
    """Descents at their beginnings."""
    f = context.by_clicks.freedom
    points = triangulated(data.clicks, len(context.whole.landmarks))
    found = []
    for usual in _usual_poses(context, points, data, start):
        sigma = pose_sigmas(f, *(_USUAL if start is None else _NEARBY))
        expected = Expected(usual, sigma)
        begin = f.still(pose_at(points, context.body, context.whole, usual))
        descent = Descent(f, context.settings, data.clicks, expected)
        found.append(_Way(descent, begin, expected, np.inf))
    return found


def _further(way: _Way, sigma: FloatArray, *, roughly: bool = False) -> _Way:
    state, cost = way.descent.descend(way.state, sigma, _STEPS, roughly=roughly)
    return dataclasses.replace(way, state=state, cost=cost)


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
    """What is known in the end; with measured points, fitted once more together with them."""
    if data.depth is None:
        judgement, P = way.descent.judged(way.state, sigma)
        return Fitted([way.state], P[None], [judgement])
    stretch, firmly = context.by_depth, way.expected.sigma
    data = dataclasses.replace(data, clicks=dataclasses.replace(data.clicks, sigma=sigma))
    firmly = np.append(firmly, np.full(stretch.freedom.of_pose - len(firmly), firmly[-1]))
    begin = dataclasses.replace(stretch.freedom.still(way.state.pose), offsets=way.state.offsets)
    return stretch.fit_one(data, begin, way.expected.pose, firmly, range(_ROUNDS))


def _missed(context: FitContext, data: FrameData, pose: Pose) -> float:
    if data.depth is None:
        return 0.0
    return depth_cost(context.by_depth, data.depth.points, pose)


def _usual_poses(
    context: FitContext, points: FloatArray, data: FrameData, start: Pose | None
) -> tuple[Pose, ...]:
    """Poses to begin from: one where the trunk shows how it is turned, else four ways round."""
    if start is not None:
        return (start,)
    place = _place(context, data)
    if not len(data.clicks) and data.depth is None:
        return (context.usual,)
    names = context.whole.names
    known = [bool(np.isfinite(points[names.index(name)]).all()) for name in TRUNK]
    if sum(known) >= _ENOUGH:
        x = pose_at(points, context.body, context.whole, context.usual).torso[:, 0]
        return (standing(context.body, place, float(np.arctan2(x[1], x[0]))),)
    quarters = 0.5 * np.pi * np.arange(4)
    return tuple(standing(context.body, place, float(yaw)) for yaw in quarters)


def _place(context: FitContext, data: FrameData) -> FloatArray:
    """Where the middle of the trunk is looked for: under the top of the measured points."""
    if data.depth is None or not len(data.depth.points):
        return watched_place(context.cameras)
    points = data.depth.points
    lengths = context.body.skeleton.proportions
    below = 0.5 * lengths.torso_length + lengths.shoulder_to_head
    top = float(np.percentile(points[:, 2], _TOP))
    return np.append(np.median(points[:, :2], axis=0), top - below)


def _as_frame(
    context: FitContext,
    freedom: Freedom,
    measurements: Sequence[ClickMeasurement],
    found: Fitted,
    factor: float,
) -> FrameFit:
    state, P, judgement = found.states[0], found.P[0], found.judgements[0]
    names = context.asked.names
    report = reported(freedom, state, P, len(names))
    residual = exact_residuals(measurements, names, report.places, context.cameras)
    return FrameFit(
        pose=state.pose,
        covariance=P,
        landmarks_world=report.places,
        landmark_covariance=report.covariance,
        residual_px=residual,
        leverage=judgement.leverage,
        mistake=judgement.mistake,
        limb_sigma_deg=report.limb_sigma_deg,
        used_cameras=used_cameras(measurements, names, judgement.mistake),
        words=(
            *_rough(factor),
            *words(
                names, report, measurements, judgement, residual, context.cameras, context.views
            ),
        ),
        sigma_factor=factor,
    )


def _rough(factor: float) -> tuple[str, ...]:
    if factor <= 1.0:
        return ()
    return (f"the clicks scatter {factor:.1f} times as much as their stated uncertainty",)
