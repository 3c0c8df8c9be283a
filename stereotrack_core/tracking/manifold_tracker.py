"""The tracker of preset ``accurate``: data look for the model, on the manifold of poses."""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter

import numpy as np
import scipy.linalg

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.angles import state_names, state_of_pose
from stereotrack_core.body.jacobian import columns_of
from stereotrack_core.body.manifold import difference, displaced
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import Pose, orthonormal, t_pose
from stereotrack_core.body.skeleton import CLAVICLES, FOREARMS, UPPER_ARMS
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.filtering.linearisation import posterior
from stereotrack_core.filtering.sigma_points import scaled_weights, sigma_deviations
from stereotrack_core.tracking.confidence import (
    surface_distances,
    unexplained_fraction,
    unexplained_fraction_of,
)
from stereotrack_core.tracking.data_to_model import SurfaceResidual, Trust, surface_residual
from stereotrack_core.tracking.estimate import (
    OVERCONFIDENCE,
    Correspondences,
    Estimate,
    Memory,
    Prior,
    limb_sigma_deg,
)
from stereotrack_core.tracking.inside.observer import SILENT, Observer
from stereotrack_core.tracking.limits import limit_residuals
from stereotrack_core.tracking.lost.judge import lost_probability
from stereotrack_core.tracking.lost.signs import Judged, limb_signs, unexpected
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.process import elapsed, process_noise, time_array, time_in
from stereotrack_core.tracking.residuals import (
    Observation,
    Residual,
    gathered,
    gathered_by_sigma_points,
    innovation_of,
)
from stereotrack_core.tracking.search.search import ArmSearch
from stereotrack_core.tracking.sensors import sensors_for

_COARSE = 2
"""All iterations but the last use every second datum; the variances make up for it."""

_STEP_LIMIT = 0.5
"""Radians and metres by which one iteration may move a number of the error state."""

_WIDE_ITERATIONS = 2

_ARM = np.radians(40.0) ** 2
_START = np.array([0.1, 0.1, 0.1, *np.radians([20.0, 20.0, 20.0])]) ** 2
"""Variances of joints, and of position and rotation, of a first pose."""

_WIDE_ARM = np.radians(40.0)
"""Standard deviation of the arms' joints around a proposal."""


@dataclass(frozen=True, eq=False)
class State:
    """What a tracker carries from frame to frame.

    Attributes
    ----------
    pose : Pose
    P : (n, n) float64
        Covariance of the pose's error state.
    movement : (n,) float64
        By which the pose has moved in a frame.
    time : float or None
        Frame that they belong to; None: the one before the next cloud's.
    """

    pose: Pose
    P: FloatArray
    movement: FloatArray
    time: float | None


class ManifoldTracker:
    """Predict, then iterate posterior linearisation of the distances to the surface.

    Parameters are those of :class:`ThesisTracker`.

    Attributes
    ----------
    observer : Observer
        Is told what happens inside a frame.
    origin : State
        From which the last step went out; what it was started with before the first.
    """

    observer: Observer = SILENT

    def __init__(
        self,
        body: BodyModel,
        parameters: TrackingParameters,
        cameras: FloatArray,
        fps: float,
        seed: int,
    ) -> None:
        self.body = body
        self.parameters = parameters
        self.cameras = cameras
        self.joints = body.joints
        self.state_names = state_names(self.joints)
        self.Q = process_noise(parameters, self.joints, fps)
        p = parameters
        self._weights = scaled_weights(len(self.Q), p.ut_alpha, p.ut_beta, p.ut_kappa)
        self._columns = columns_of(self.joints)
        self._seed = seed
        self._search = ArmSearch(body, parameters.search, parameters.arms_apart)
        self._sensors = sensors_for(parameters)
        self.start(t_pose(np.zeros(3)))

    def start(self, pose: Pose, time: float | None = None) -> None:
        """Begin from a pose that is roughly right.

        Parameters
        ----------
        pose : Pose
        time : float, optional
            Frame that it belongs to; where not given, the one before the next cloud's.
        """
        girdle = np.radians(self.parameters.girdle_rest) ** 2
        turns = [girdle if joint in CLAVICLES else _ARM for joint in self.joints]
        P = np.diag(np.concatenate([_START, np.repeat(turns, 2)]))
        self.resume(State(pose, P, np.zeros(len(self.Q)), time))
        self._gone = 1.0
        self._observed: tuple[Observation, ...] = ()
        self._seen: Cloud | None = None
        self._prior: Prior | None = None
        self._anew = True

    @property
    def state(self) -> State:
        """Where it is."""
        return State(self.pose, self.P, self.movement, self.time)

    def resume(self, state: State) -> None:
        """Go on from a state."""
        self.pose, self.P = state.pose, state.P
        self.movement, self.time = state.movement, state.time
        self.origin = state

    def step(self, cloud: Cloud) -> Estimate:
        """Follow to the next cloud (docs/method.md 4.4)."""
        begun = perf_counter()
        self.origin = before = self.state
        self._gone = elapsed(before.time, cloud.frame)
        self.predict(cloud.frame)
        self.observer.predicted(before, self.pose, self.P)
        if len(cloud.points) < self.parameters.least_points:
            return self.lost(before, cloud, f"the cloud has only {len(cloud.points)} points")
        data = self.choose(cloud)
        surface, innovation = self.track(cloud, data)
        if (
            unexplained_fraction(surface_distances(data, self.body, self.pose))
            > self.parameters.max_unexplained_fraction
        ):
            return self.lost(before, cloud, "the cloud does not look like the body")
        self.pose = orthonormal(self.pose)
        if self._gone:
            self.movement = difference(self.pose, before.pose, self.joints) / self._gone
        self._prior, self._anew = None if self._anew else self._prior, False
        return self.estimate(cloud, surface, innovation, perf_counter() - begun)

    def memory(self) -> Memory:
        """All that the next step depends on; see :class:`Tracker`."""
        return {
            "position": self.pose.position,
            "rotations": self.pose.rotations,
            "P": self.P,
            "movement": self.movement,
            "time": time_array(self.time),
            "anew": np.array(self._anew),
        }

    def recall(self, memory: Memory) -> None:
        """Go on as the tracker would whose memory this is."""
        pose = Pose(memory["position"], memory["rotations"])
        self.start(pose)
        self.resume(State(pose, memory["P"], memory["movement"], time_in(memory["time"])))
        self._anew = bool(memory["anew"])

    def observe(self, cloud: Cloud) -> None:
        """Let all sensors see the frame, once."""
        if self._seen is cloud:
            return
        self._seen = cloud
        self._observed = tuple(sensor.observe(cloud) for sensor in self._sensors)

    def track(self, cloud: Cloud, data: FloatArray) -> tuple[SurfaceResidual, float]:
        """Correct the predicted pose; returns the last pairs and the normalised innovation."""
        self.observe(cloud)
        predicted, P0 = self.pose, self.P
        first, surface = self.follow(data, predicted, P0)
        innovation = innovation_of(first, self.body, predicted, P0, self._columns)
        hurried = self.widened(predicted, P0)
        if hurried is not None:
            P0 = hurried
            self.observer.widened(P0)
            _, surface = self.follow(data, predicted, P0)
        carried = np.ones(len(P0), dtype=np.bool_)
        if self.parameters.search.search_arms:
            followed = surface
            surface = self.search_arms(cloud, data, predicted, P0, followed)
            carried[self._arm_columns()] = surface is followed
        self._prior = self.prior(P0, carried)
        return surface, innovation

    def predict(self, time: float) -> None:
        """Predict a damped repetition of the last movement, with the uncertainty of the time.

        Where no time goes by, nothing is predicted.
        """
        if gone := elapsed(self.time, time):
            self.pose = displaced(self.pose, self._expected(gone), self.joints)
            self.P = self.P + gone * self.Q
        self.time = time

    def _expected(self, gone: float) -> FloatArray:
        return gone * self.parameters.velocity * self.movement

    def prior(self, P0: FloatArray, carried: BoolArray) -> Prior:
        """What the frame's correction has begun from, seen from where the step began."""
        return Prior(self._expected(self._gone), P0, carried)

    def choose(self, cloud: Cloud) -> FloatArray:
        """Draw the data (N, 3) evenly from the cloud; the same for the same frame."""
        wanted, there = self.parameters.data_points, len(cloud.points)
        if there <= wanted:
            return cloud.points
        rng = np.random.default_rng((self._seed, cloud.frame))
        return cloud.points[np.sort(rng.choice(there, wanted, replace=False))]

    def follow(
        self, data: FloatArray, prior: Pose, P0: FloatArray
    ) -> tuple[SurfaceResidual, SurfaceResidual]:
        """Iterate correspondences and corrections; returns the first and the last pairs."""
        surfaces, last = [], self.parameters.iterations - 1
        for i in range(self.parameters.iterations):
            surfaces.append(self.correspond(data if i == last else data[::_COARSE], i))
            self.correct(prior, P0, surfaces[-1])
        return surfaces[0], surfaces[-1]

    def widened(self, predicted: Pose, P0: FloatArray) -> FloatArray | None:
        """Widen the prior where the data ask for more movement than it allows for.

        Position, rotation and every joint are judged alone by the distance that they were moved
        over its expected value; None where nothing moved unexpectedly far. A narrow prior holds
        still limbs still, and yet nothing that moves fast is held back.
        """
        moved = difference(self.pose, predicted, self.joints) ** 2 / np.diagonal(P0)
        groups = [moved[:3].mean(), moved[3:6].mean(), *moved[6:].reshape(-1, 2).mean(axis=1)]
        ratio = np.sqrt(np.repeat(groups, [3, 3] + [2] * len(self.joints)))
        factor = np.where(ratio > self.parameters.hurry, ratio, 1.0)
        if not np.any(factor > 1.0):
            return None
        wider: FloatArray = P0 * np.outer(factor, factor)
        return wider

    def search_arms(
        self,
        cloud: Cloud,
        data: FloatArray,
        predicted: Pose,
        P0: FloatArray,
        followed: SurfaceResidual,
    ) -> SurfaceResidual:
        """Put the arms elsewhere if both together explain the frame clearly better there."""
        rng = np.random.default_rng((self._seed, cloud.frame, 1))
        evidence = self._search.evidence(cloud, self.pose, rng)
        best = (self.pose, self.P, followed)
        least = (
            self._search.cost(evidence, predicted, self.pose) - self._search.parameters.search_gain
        )
        here, watch = self.pose, self.observer
        watch.searching(evidence, predicted, here)
        for _, proposed in self._search.best_pairs(evidence, predicted, here, rng, watch):
            watch.refining(proposed)
            surface = self.refine(data, proposed, P0)
            cost = self._search.cost(evidence, predicted, self.pose)
            watch.refined(self.pose, cost)
            if cost < least:
                least, best = cost, (self.pose, self.P, surface)
        self.pose, self.P, surface = best
        watch.searched(self.pose)
        return surface

    def refine(self, data: FloatArray, proposed: Pose, P0: FloatArray) -> SurfaceResidual:
        """Correct a proposed pose from a prior that is wide for the arms."""
        P = P0.copy()
        columns = self._arm_columns()
        P[columns] = P[:, columns] = 0.0
        P[columns, columns] = _WIDE_ARM**2
        self.pose, self.P = proposed, P
        for i in range(self.parameters.search.search_iterations):
            surface = self.correspond(data[::_COARSE], i + 1)
            self.correct(proposed, P, surface)
        return surface

    def _arm_columns(self) -> IntArray:
        return np.concatenate([self._column(part) for part in (*UPPER_ARMS, *FOREARMS)])

    def _column(self, part: int) -> IntArray:
        first = 6 + 2 * self.joints.index(part)
        return np.arange(first, first + 2)

    def correspond(self, data: FloatArray, iteration: int) -> SurfaceResidual:
        """Give the data to the cones that are nearest at the present pose."""
        p = self.parameters
        scale = p.robust_wide if iteration < _WIDE_ITERATIONS else p.robust_narrow
        trust = Trust(p.reach, scale, p.sigma_measurement, p.effective_points)
        surface = surface_residual(data, self.body, self.body.frames(self.pose), trust)
        self.observer.corresponded(data, surface)
        return surface

    def correct(self, prior: Pose, P0: FloatArray, surface: SurfaceResidual) -> None:
        """Linearise at the present posterior, correct the frame's prior."""
        residuals: tuple[Residual, ...] = (
            surface,
            *(row for seen in self._observed for row in seen.residuals(self.body, self.pose)),
            *limit_residuals(self.body, self.pose, self.parameters, self.joints),
        )
        self.observer.correcting(prior, P0, self.pose, self.P, residuals)
        if self.parameters.linearisation == "sigma_points":
            found = gathered_by_sigma_points(
                residuals, self.body, self.pose, self.P, self._weights, self.joints
            )
        else:
            found = gathered(residuals, self.body, self.pose, self._columns)
        from_prior = difference(prior, self.pose, self.joints)
        P0_inverse: FloatArray = scipy.linalg.inv(P0)
        dx, self.P = posterior(P0_inverse, from_prior, found)
        self.pose = displaced(self.pose, np.clip(dx, -_STEP_LIMIT, _STEP_LIMIT), self.joints)
        self.observer.corrected(self.pose, self.P, dx)

    def lost(self, before: State, cloud: Cloud, reason: str) -> Estimate:
        """State a frame in which nothing could be measured; the body is expected to stay."""
        P = before.P + elapsed(before.time, cloud.frame) * self.Q
        self.resume(State(before.pose, P, np.zeros_like(before.movement), cloud.frame))
        return Estimate(False, reason, before.pose, state_of_pose(before.pose, self.joints), P)

    def estimate(
        self, cloud: Cloud, surface: SurfaceResidual, innovation: float, seconds: float
    ) -> Estimate:
        """State the pose with the signs by which it can be judged."""
        frames = self.body.frames(self.pose)
        spread = self.body.frames(
            displaced(self.pose, sigma_deviations(self.P, self._weights), self.joints)
        )
        weight = surface.weight
        squared = float(weight @ surface.distance**2) / max(float(weight.sum()), 1e-12)
        begun = perf_counter()
        sigma = limb_sigma_deg(spread, self._weights.covariance)
        pairs = Correspondences(surface.data, surface.foot, surface.part, weight)
        share = unexplained_fraction_of(cloud.points, self.body, frames)
        jump = unexpected(self._gone * self.movement, self._prior, self.joints)
        judged = Judged(self.pose, frames, sigma, share, pairs, jump)
        signs = limb_signs(cloud, self.body, judged)
        return Estimate(
            tracked=True,
            reason="",
            pose=self.pose,
            x=state_of_pose(self.pose, self.joints),
            P=self.P.copy(),
            unexplained_fraction=share,
            residual=float(np.sqrt(squared)),
            innovation=innovation,
            limb_sigma_deg=OVERCONFIDENCE * sigma,
            limb_lost=lost_probability(signs),
            limb_signs=signs,
            correspondences=pairs,
            seconds={"track": seconds, "judge": perf_counter() - begun},
            prior=self._prior,
        )
