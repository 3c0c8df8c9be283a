"""One frame fitted by itself, while somebody clicks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stereotrack_core.annotation.fit.context import FitContext
from stereotrack_core.annotation.fit.depth import MeasuredDepth
from stereotrack_core.annotation.fit.measurement import ClickMeasurement
from stereotrack_core.annotation.fit.movement import pose_sigmas
from stereotrack_core.annotation.fit.report import (
    exact_residuals,
    reported,
    used_cameras,
    words,
)
from stereotrack_core.annotation.fit.results import FrameFit
from stereotrack_core.annotation.fit.start import TRUNK, pose_at, standing, watched_place
from stereotrack_core.annotation.fit.state import Freedom
from stereotrack_core.annotation.fit.stretch import Fitted, FrameData
from stereotrack_core.annotation.fit.triangulate import triangulated
from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.pose import Pose
from stereotrack_core.depth.cloud import Cloud

_ROUNDS = 8

_USUAL = (1.0, 60.0, 50.0)
"""How far a body may be from the usual pose: metres; degrees of the torso, of a joint."""

_NEARBY = (0.2, 30.0, 40.0)
"""How far it may be from a pose nearby."""

_ENOUGH = 3
"""Landmarks of the trunk that tell how it is turned."""

_LARGEST = 25.0
"""What one click can cost at most when starts are compared."""


def fitted_frame(
    context: FitContext,
    measurements: Sequence[ClickMeasurement],
    cloud: Cloud | MeasuredDepth | None,
    start: Pose | None,
) -> FrameFit:
    """Fit one frame; see :meth:`ClickFit.frame`."""
    data = context.data(measurements, cloud)
    stretch = context.by_clicks if data.depth is None else context.by_depth
    points = triangulated([data.clicks], context.cameras, len(context.whole.landmarks))[0]
    best: Fitted | None = None
    least = np.inf
    for usual in _usual_poses(context, points, len(data.clicks), start):
        begin = pose_at(points, context.body, context.whole, usual)
        sigma = pose_sigmas(stretch.freedom, *(_USUAL if start is None else _NEARBY))
        found = stretch.fit([data], [begin], usual, sigma, rounds=_ROUNDS)
        cost = _cost(data, found)
        if best is None or cost < least:
            best, least = found, cost
    assert best is not None  # noqa: S101 - there is always a usual pose
    return _as_frame(context, stretch.freedom, measurements, best)


def _usual_poses(
    context: FitContext, points: FloatArray, clicks: int, start: Pose | None
) -> tuple[Pose, ...]:
    """Poses to begin from: one where the trunk shows how it is turned, else four ways round."""
    if start is not None:
        return (start,)
    names, place = context.whole.names, watched_place(context.cameras)
    if not clicks:
        return (context.usual,)
    known = [bool(np.isfinite(points[names.index(name)]).all()) for name in TRUNK]
    if sum(known) >= _ENOUGH:
        x = pose_at(points, context.body, context.whole, context.usual).torso[:, 0]
        return (standing(context.body, place, float(np.arctan2(x[1], x[0]))),)
    quarters = 0.5 * np.pi * np.arange(4)
    return tuple(standing(context.body, place, float(yaw)) for yaw in quarters)


def _cost(data: FrameData, found: Fitted) -> float:
    if not len(data.clicks):
        return 0.0
    return float(np.minimum(found.judgements[0].surprise, _LARGEST).sum())


def _as_frame(
    context: FitContext,
    freedom: Freedom,
    measurements: Sequence[ClickMeasurement],
    found: Fitted,
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
        words=words(
            names, report, measurements, judgement, residual, context.cameras, context.views
        ),
    )
