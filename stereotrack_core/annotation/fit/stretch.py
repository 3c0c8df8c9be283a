"""Successive frames fitted together: linearise everywhere, smooth, judge the clicks, again."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stereotrack_core.annotation.fit.residuals import (
    BiasedSurface,
    ClickResidual,
    Clicks,
    Judgement,
    judged,
    mixture_weight,
)
from stereotrack_core.annotation.fit.state import (
    FitSettings,
    FitState,
    Freedom,
    Movement,
    biased,
    shift_sigmas,
)
from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import PartFrames, Pose, rotation_towards
from stereotrack_core.body.skeleton import PARENTS, PARTS, TORSO
from stereotrack_core.depth.chain import DepthChain
from stereotrack_core.depth.cloud import Cloud, EdgeMap
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.volume import settled
from stereotrack_core.filtering.linearisation import Information, posterior
from stereotrack_core.filtering.smoothing import smooth
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.tracking.correction import gathered
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.residuals.limits import limit_rows
from stereotrack_core.tracking.residuals.silhouette import SilhouetteObservation, edge_maps
from stereotrack_core.tracking.residuals.surface import (
    FIRST_LOSS,
    Trust,
    surface_distances,
    surface_residual,
)

_FARTHEST = 1.0e4  # pixels and metres up to which half precision must hold them
_POINTS = 1000  # of a cloud that are kept


@dataclass(frozen=True, eq=False)
class MeasuredDepth:
    """Points (N, 3), world, of one instant, small enough that those of a recording are kept."""

    points: FloatArray
    _halves: tuple[EdgeMap, ...]  # edges in half precision, which is enough near an edge

    def edges(self) -> tuple[EdgeMap, ...]:
        """Edges of the person in the views that know them."""
        return tuple(_as_type(edge, np.float32) for edge in self._halves)


def _as_type(edge: EdgeMap, kind: type[np.floating[Any]]) -> EdgeMap:
    distance, range_z = (
        np.clip(one, -_FARTHEST, _FARTHEST).astype(kind) for one in (edge.distance, edge.range_z)
    )
    return replace(edge, distance=distance, range_z=range_z)


def measured_depth(cloud: Cloud) -> MeasuredDepth:
    """Keep of a cloud what the fit needs: points, drawn evenly, the same for the same frame."""
    points = cloud.points
    if len(points) > _POINTS:
        rng = np.random.default_rng(cloud.frame)
        points = points[np.sort(rng.choice(len(points), _POINTS, replace=False))]
    return MeasuredDepth(points, tuple(_as_type(edge, np.float16) for edge in edge_maps(cloud)))


@contextmanager
def recorded_depth(
    recording: Recording, settings: FitSettings, views: Sequence[str] | None = None
) -> Iterator[Callable[[int], MeasuredDepth] | None]:
    """Give a function from frame to depth, or None where there is none. Raises InputError."""
    deep = (view.name for view in recording.views if view.kind != "mono")
    names = [name for name in deep if views is None or name in views]
    if not names or not settings.use_depth:
        yield None
        return
    with FrameReader(recording, views=names, colour=False) as reader:
        parameters = settled(recording, DepthParameters(), reader, names)
        with closing(DepthChain(recording, parameters, views=names)) as chain:
            chain.learn_background(reader, range(reader.frame_count))
            yield lambda frame: measured_depth(chain.process(reader.frame_set(frame)))


_LEAST_SIGMAS = (20.0, 12.0, 6.0)  # pixels that clicks scatter at least in the first rounds
_INDEPENDENT_POINTS, _INDEPENDENT_CONTOURS = 60.0, 52.0  # effective sample sizes of a frame
_WIDE_ROUNDS = 2  # rounds in which measured points are let in from far
_LEGS_LOOSER = 3.0  # factor on the standard deviation of points of the legs
_STEP_LIMIT = 0.5  # radians and metres by which one round may move a number of the error state


@dataclass(frozen=True, eq=False)
class FrameData:
    """Clicks and depth of one frame."""

    clicks: Clicks
    depth: MeasuredDepth | None = None


@dataclass(frozen=True, eq=False)
class Fitted:
    """K frames of a stretch: their states with covariances P (K, n, n), and what clicks are."""

    states: Sequence[FitState]
    P: FloatArray
    judgements: Sequence[Judgement]


class Stretch:
    """Fits successive frames together."""

    def __init__(self, freedom: Freedom, settings: FitSettings, fps: float) -> None:
        self.freedom = freedom
        self.settings = settings
        self.movement = Movement(freedom, settings, fps)
        self._limits = TrackingParameters()

    def fit(
        self,
        data: Sequence[FrameData],
        start: Sequence[Pose],
        usual: Pose,
        pose_sigma: FloatArray,
        *,
        rounds: int,
    ) -> Fitted:
        """Fit all frames, from poses that are roughly right; `usual` is the first one's.

        `pose_sigma` (of_pose,) says how firmly that is expected.
        """
        f, move = self.freedom, self.movement
        n = f.columns.n
        states = [f.still(pose) for pose in _without_twists(start)]
        speeds = np.zeros((len(data), f.of_pose))
        factors = np.ones((len(data) - 1, f.of_pose))
        judgements = [_all_right(frame.clicks) for frame in data]
        for i in range(rounds):
            every = zip(data, states, judgements, strict=True)
            measured = [self.information(*args, i) for args in every]
            found = smooth(move.walk(states, speeds, factors, usual, pose_sigma), measured)
            step = np.clip(found.mean, -_STEP_LIMIT, _STEP_LIMIT)
            states = [f.displaced(s, d[:n]) for s, d in zip(states, step, strict=True)]
            speeds = speeds + step[:, n:]
            factors = move.factors(found.noise)
            P = found.P[:, :n, :n]
            judgements = [
                self.judge(frame.clicks, state, cov, old, i)
                for frame, state, cov, old in zip(data, states, P, judgements, strict=True)
            ]
        return Fitted(states, P, judgements)

    def fit_one(
        self,
        frame: FrameData,
        begin: FitState,
        usual: Pose,
        pose_sigma: FloatArray,
        rounds: Iterable[int],
    ) -> Fitted:
        """Fit one frame from a state that is nearly right, in some rounds of :meth:`fit`."""
        f = self.freedom
        prior = np.concatenate([pose_sigma, shift_sigmas(f, self.settings)]) ** -2.0
        P, state = np.diag(1.0 / prior), begin
        weighed = judgement = self.weighed(frame.clicks, begin)
        for i in rounds:
            shifts = np.concatenate([state.offsets.ravel(), state.biases.ravel()])
            away = np.concatenate([f.pose_difference(usual, state.pose), -shifts])
            measured = self.information(frame, state, weighed, i)
            step, P = posterior(np.diag(prior), away, measured)
            state = f.displaced(state, np.clip(step, -_STEP_LIMIT, _STEP_LIMIT))
            judgement = self.judge(frame.clicks, state, P, weighed, i)
            weighed = self.weighed(frame.clicks, state)
        return Fitted([state], P[None], [judgement])

    def information(
        self, frame: FrameData, state: FitState, judgement: Judgement, i: int
    ) -> Information:
        """Information of the frame's measurements in round `i`, linearised at a state."""
        f = self.freedom
        body = f.body_at(state.offsets)
        frames = body.frames(state.pose)
        limits = limit_rows(body, state.pose, self._limits, f.joints)
        total, rows = gathered((limits,), frames, f.columns), list[ClickResidual | BiasedSurface]()
        if len(frame.clicks):
            variance = _sigmas(frame.clicks, i) ** 2 / judgement.weight
            rows.append(self._click_residual(frame.clicks, state, variance))
        if f.with_depth and frame.depth is not None and len(frame.depth.points):
            off = biased(frames, state.biases)
            rows.append(self.surface(frame.depth.points, body, off, i))
            edges = SilhouetteObservation(
                frame.depth.edges(), self._limits.silhouette_sigma, _INDEPENDENT_CONTOURS
            )
            rows += (BiasedSurface(row, f, off) for row in edges.residuals(body, state.pose))
        return sum((row.information(frames) for row in rows), total)

    def _click_residual(
        self, clicks: Clicks, state: FitState, variance: FloatArray | float = 1.0
    ) -> ClickResidual:
        own = self.freedom.own_place(state.offsets)
        variances = np.repeat(np.broadcast_to(variance, len(clicks)), 2)
        return ClickResidual(clicks, self.freedom, own, variances)

    def surface(
        self, points: FloatArray, body: BodyModel, off: PartFrames, i: int
    ) -> BiasedSurface:
        """Pair measured points with the surface, which is `off` its parts by their bias."""
        p = self._limits
        scale = p.loss_scale * (FIRST_LOSS if i < _WIDE_ROUNDS else 1.0)
        trust = Trust(
            p.max_correspondence_distance, scale, p.sigma_measurement, _INDEPENDENT_POINTS
        )
        row = surface_residual(points, body, off, trust)
        # legs are there to take their data; their cones are too rough to say where the hips are
        loose = np.where(row.part < len(LIMBS), 1.0, _LEGS_LOOSER**2)
        return BiasedSurface(replace(row, variance=row.variance * loose), self.freedom, off)

    def weighed(self, clicks: Clicks, state: FitState) -> Judgement:
        """Weigh the clicks of a frame by where a state puts their landmarks."""
        row = self._click_residual(clicks, state)
        residual = row.missed(self.freedom.body_at(state.offsets).frames(state.pose))
        weight = mixture_weight(residual, clicks.sigma, clicks.share)
        return replace(_all_right(clicks), outlier_probability=1.0 - weight)

    def judge(
        self, clicks: Clicks, state: FitState, P: FloatArray, old: Judgement, i: int
    ) -> Judgement:
        """Judge the clicks of a frame after round `i`."""
        if not len(clicks):
            return old
        row, sigma = self._click_residual(clicks, state), _sigmas(clicks, i)
        frames = self.freedom.body_at(state.offsets).frames(state.pose)
        J = row.jacobian(frames).reshape(len(clicks), 2, -1)
        residual = row.missed(frames)
        spread = J @ P @ np.swapaxes(J, 1, 2)
        return judged(residual, spread, sigma, old.weight, clicks.share)


def _sigmas(clicks: Clicks, i: int) -> FloatArray:
    """Pixels (M,) that right clicks are taken to scatter in round `i`."""
    return np.maximum(clicks.sigma, _LEAST_SIGMAS[i] if i < len(_LEAST_SIGMAS) else 0.0)


def depth_cost(stretch: Stretch, points: FloatArray, pose: Pose) -> float:
    """Cost of a pose by measured points (N, 3)."""
    if not len(points):
        return 0.0
    p = TrackingParameters()
    distance = surface_distances(points, stretch.freedom.body, pose)
    squared = np.minimum(distance, 1.0) ** 2
    limited = squared / (1.0 + squared / p.loss_scale**2) / p.sigma_measurement**2
    return _INDEPENDENT_POINTS * float(limited.mean())


def _without_twists(poses: Sequence[Pose]) -> list[Pose]:
    """The same poses, parts turned about their own axes as little as can be between frames."""
    found: list[Pose] = []
    for pose in poses:
        if found:
            rotations = pose.rotations.copy()
            before = found[-1].rotations
            turned = pose.rotations
            for part in range(1, len(PARTS)):
                parent = PARENTS[part]
                undone = np.eye(3)
                if parent != TORSO:
                    undone = rotations[parent].T @ turned[parent]
                direction = undone @ turned[part][:, 2]
                rotations[part] = rotation_towards(before[part], direction)
            pose = replace(pose, rotations=rotations)
        found.append(pose)
    return found


def _all_right(clicks: Clicks) -> Judgement:
    nothing = np.zeros(len(clicks))
    return Judgement(nothing, nothing, nothing)
