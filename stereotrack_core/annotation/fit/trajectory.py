"""Clicks followed over the frames, forward and backward, and the frames between them filled."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.annotation.click import ClickKey
from stereotrack_core.annotation.fit.between import asked_between, told_by_clicks
from stereotrack_core.annotation.fit.context import FitContext
from stereotrack_core.annotation.fit.depth import MeasuredDepth
from stereotrack_core.annotation.fit.measurement import ClickMeasurement
from stereotrack_core.annotation.fit.mistakes import MEDIAN_SURPRISE
from stereotrack_core.annotation.fit.movement import pose_sigmas
from stereotrack_core.annotation.fit.report import exact_residuals, reported
from stereotrack_core.annotation.fit.results import CLICKED, GAP, INTERPOLATED, TrajectoryFit
from stereotrack_core.annotation.fit.start import filled_over_time, pose_at, triangulated
from stereotrack_core.annotation.fit.stretch import Fitted, FrameData, Stretch
from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.pose import Pose
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.errors import Cancelled
from stereotrack_core.recording.landmarks import LANDMARKS

_ROUNDS = 8

_ANYWHERE = (2.0, 120.0, 90.0)
"""How far the first pose may be from where it was begun: metres; degrees of torso and joints."""

Clouds = Callable[[int], Cloud | MeasuredDepth | None]
"""Depth of a frame; None where there is none."""


@dataclass(frozen=True, eq=False)
class _Filled:
    """A stretch and what was found."""

    frames: range
    stretch: Stretch
    found: Fitted


def fitted_trajectory(
    context: FitContext,
    measurements: Mapping[int, Sequence[ClickMeasurement]],
    frames: range,
    clouds: Clouds | None,
    gaps: Sequence[range],
    on_frame: Callable[[int], None] | None,
    cancelled: Callable[[], bool] | None,
) -> TrajectoryFit:
    """Fit all frames; see :meth:`ClickFit.trajectory`."""
    clicked = {frame: tuple(measurements.get(frame, ())) for frame in frames}
    filled = []
    for stretch in _stretches(context, clicked, frames, gaps, clouds is not None):
        data = []
        for frame in stretch:
            if cancelled is not None and cancelled():
                raise Cancelled
            cloud = None
            if clouds is not None and context.settings.use_depth:
                cloud = clouds(frame)
            data.append(context.data(clicked[frame], cloud))
            if on_frame is not None:
                on_frame(frame)
        filled.append(_fit(context, stretch, data, cancelled))
    return _put_together(context, clicked, frames, filled)


def _stretches(
    context: FitContext,
    clicked: Mapping[int, Sequence[ClickMeasurement]],
    frames: range,
    gaps: Sequence[range],
    has_depth: bool,
) -> list[range]:
    """Frames that hang together: between gaps, and near enough to a clicked frame."""
    near = np.array([not any(frame in gap for gap in gaps) for frame in frames], dtype=np.bool_)
    own = np.array([bool(clicked[frame]) for frame in frames], dtype=np.bool_)
    found: list[range] = []
    for run in _runs(near):
        inside = np.flatnonzero(own[run.start : run.stop]) + run.start
        if not len(inside):
            continue
        reach = len(frames)
        if not (has_depth and context.settings.use_depth):
            reach = int(context.settings.longest_fill * context.fps)
        away = np.abs(np.arange(run.start, run.stop)[:, None] - inside).min(axis=1)
        kept = _runs(away <= reach)
        found += [frames[run.start + one.start : run.start + one.stop] for one in kept]
    return found


def _runs(wanted: np.typing.NDArray[np.bool_]) -> list[range]:
    """Runs of True as index ranges."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], wanted.astype(np.int8), [0]])))
    return [range(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def _fit(
    context: FitContext,
    frames: range,
    data: Sequence[FrameData],
    cancelled: Callable[[], bool] | None,
) -> _Filled:
    """Fit the clicks alone, and with what that gives to begin from, clicks and depth."""
    seen = [triangulated(one.clicks, len(context.whole.names)) for one in data]
    points = filled_over_time(np.array(seen))
    start = [pose_at(point, context.body, context.whole, context.usual) for point in points]
    stretch = context.by_clicks
    known = told_by_clicks(stretch, data, len(context.asked.landmarks))
    found = _together(stretch, data, start, cancelled)
    if not known.all():
        start = [state.pose for state in found.states]
        start = asked_between(stretch, data, start, known, context.fps, cancelled)
        found = _together(stretch, data, start, cancelled)
    if not any(one.depth is not None for one in data):
        return _Filled(frames, stretch, found)
    start = [state.pose for state in found.states]
    context = context.shaped(data, start, np.flatnonzero(known))
    stretch = context.by_depth
    start = asked_between(stretch, data, start, known, context.fps, cancelled)
    return _Filled(frames, stretch, _together(stretch, data, start, cancelled))


def _together(
    stretch: Stretch,
    data: Sequence[FrameData],
    start: Sequence[Pose],
    cancelled: Callable[[], bool] | None,
) -> Fitted:
    sigma = pose_sigmas(stretch.freedom, *_ANYWHERE)
    return stretch.fit(data, start, start[0], sigma, rounds=_ROUNDS, cancelled=cancelled)


def _put_together(
    context: FitContext,
    clicked: Mapping[int, Sequence[ClickMeasurement]],
    frames: range,
    filled: Sequence[_Filled],
) -> TrajectoryFit:
    names, count = context.asked.names, len(frames)
    places = np.full((count, len(names), 3), np.nan)
    covariance = np.full((count, len(names), 3, 3), np.nan)
    limbs, nine = np.full((count, len(LIMBS)), np.nan), np.full((count, len(LANDMARKS), 3), np.nan)
    kind = np.full(count, GAP, dtype="U12")
    residual: dict[ClickKey, FloatArray] = {}
    mistake: dict[ClickKey, float] = {}
    surprise: list[FloatArray] = []
    for part in filled:
        found = part.found
        for i, frame in enumerate(part.frames):
            k, own = frames.index(frame), clicked[frame]
            report = reported(part.stretch.freedom, found.states[i], found.P[i], len(names))
            places[k], covariance[k] = report.places, report.covariance
            limbs[k], nine[k] = report.limb_sigma_deg, report.nine
            kind[k] = CLICKED if own else INTERPOLATED
            off = exact_residuals(own, names, report.places, context.cameras)
            judgement = found.judgements[i]
            surprise.append(judgement.surprise)
            for one, miss, p in zip(own, off, judgement.mistake, strict=True):
                residual[one.key(frame)], mistake[one.key(frame)] = miss, float(p)
    return TrajectoryFit(
        names=names,
        frame=np.array(frames, dtype=np.int64),
        landmarks=places,
        covariance=covariance,
        limb_sigma_deg=limbs,
        kind=kind,
        nine=nine,
        residual_px=residual,
        mistake=mistake,
        sigma_factor=_sigma_factor(surprise),
    )


def _sigma_factor(surprise: Sequence[FloatArray]) -> float:
    squared = np.concatenate(surprise) if surprise else np.zeros(0)
    return float(np.sqrt(np.median(squared) / MEDIAN_SURPRISE)) if len(squared) else float("nan")
