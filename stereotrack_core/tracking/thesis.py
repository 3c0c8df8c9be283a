"""The tracker of the thesis (chapter 3): model points look for the nearest measured ones."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np
import scipy
from numpy.typing import NDArray

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.angles import THESIS_JOINTS, pose_of_state, state_names, state_of_pose
from stereotrack_core.body.pose import Pose, t_pose
from stereotrack_core.body.sampling import SurfacePoints, visible_points
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.filtering.correction import correct, normalised
from stereotrack_core.filtering.sigma_points import sigma_deviations
from stereotrack_core.tracking.estimate import Correspondences, Estimate, Prior, Projection
from stereotrack_core.tracking.failure.features import judged
from stereotrack_core.tracking.residuals.limits import LEAST_ELBOW_ANGLE
from stereotrack_core.tracking.state import Belief, Setup, elapsed
from stereotrack_core.tracking.step_recorder import StepRecorder
from stereotrack_core.tracking.thesis_collisions import collisions_avoided
from stereotrack_core.tracking.trace import SigmaPoints


@dataclass(frozen=True, eq=False)
class ThesisState:
    """Everything that the next step of the thesis's tracker depends on."""

    x: FloatArray  # (n,). Position and Euler angles, :data:`state_names`.
    P: FloatArray  # (n, n). Covariance of x.
    random: NDArray[np.uint8]  # state of the random numbers that draw model points, as JSON
    time: float | None = None  # of the pose; None: the frame before the next cloud's
    is_first: bool = True  # whether no earlier frame predicts the next one

    @property
    def pose(self) -> Pose:
        """The pose that x stands for."""
        return pose_of_state(self.x, THESIS_JOINTS)

    @property
    def belief(self) -> Belief:
        """Its pose with the covariance of x."""
        return Belief(self.pose, self.P)


@dataclass(frozen=True, eq=False)
class ThesisModel:
    """Prediction, i corrections by closest points, and avoidance of collisions (chapter 3)."""

    setup: Setup

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the numbers of the state."""
        return state_names(THESIS_JOINTS)

    def first(
        self, pose: Pose, time: float | None = None, *, P: FloatArray | None = None
    ) -> ThesisState:
        """State at a pose, as uncertain as stated or as one step of the process makes it."""
        Q, x = self.setup.Q, state_of_pose(pose, THESIS_JOINTS)
        is_first = P is None or P.shape != Q.shape
        random = _random_state(np.random.default_rng(self.setup.seed))
        return ThesisState(x, Q if P is None or is_first else P.copy(), random, time, is_first)

    def absent(self) -> ThesisState:
        """State before the first frame that shows somebody."""
        return self.first(t_pose(np.zeros(3)))

    def step(
        self, before: ThesisState, cloud: Cloud, recorder: StepRecorder | None = None
    ) -> tuple[ThesisState, Estimate]:
        """Follow to the next cloud (3.2.3 and 3.2.4)."""
        begun, p, rng = perf_counter(), self.setup.parameters, _random_of(before.random)
        predicted = state = self.predict(before, cloud.frame)
        if recorder is not None:
            recorder.predicted(before.belief, state.belief)
        prior = None if before.is_first else Prior(state.P, np.ones(len(state.x), np.bool_))
        if len(cloud.points) < p.least_points:
            return _lost(state, f"the cloud has only {len(cloud.points)} points")
        tree = scipy.spatial.cKDTree(cloud.points, balanced_tree=False, compact_nodes=False)
        innovations = []
        for _ in range(p.iterations):
            sampled = self.sample(state, rng, recorder)
            predicted = replace(predicted, random=_random_state(rng))
            if not len(sampled):
                return _lost(predicted, "no part of the body is visible in any camera")
            pairs = self.closest(state, sampled, tree)
            if not len(pairs.e):
                return _lost(predicted, "every model point coincides with its measured point")
            state, innovation = self.correct(state, pairs, recorder)
            innovations.append(innovation)
        # The arms keep the least distances (3.2.4).
        jump = collisions_avoided(self.setup.body, state.pose, p.clearance, LEAST_ELBOW_ANGLE)
        x = np.append(state.x[:6], state_of_pose(jump.after, THESIS_JOINTS)[6:])
        state = replace(state, x=x, random=_random_state(rng), is_first=False)
        if recorder is not None:
            recorder.avoided(replace(jump, after=state.pose))
        seconds = {"track": perf_counter() - begun}
        found = replace(self._found(state, pairs, innovations[0]), prior=prior, seconds=seconds)
        X = pose_of_state(state.x + sigma_deviations(state.P, self.setup.weights), THESIS_JOINTS)
        dx = state.x - before.x
        movement = np.append(dx[:3], np.arctan2(np.sin(dx[3:]), np.cos(dx[3:])))
        return state, judged(found, cloud, self.setup, X, movement)

    def predict(self, state: ThesisState, time: float) -> ThesisState:
        """Predict that the body stays where it is, with more uncertainty (3.2.1)."""
        P = state.P + elapsed(state.time, time) * self.setup.Q
        return replace(state, P=P, time=time)

    def sample(
        self, state: ThesisState, rng: np.random.Generator, recorder: StepRecorder | None = None
    ) -> SurfacePoints:
        """Draw the model points G(x_hat), (3.4)."""
        setup, p = self.setup, self.setup.parameters
        drawn_by = rng if p.sampling == "random" else None
        frames, told = setup.body.frames(state.pose), None if recorder is None else recorder.sampled
        return visible_points(setup.body, frames, setup.cameras, p.model_points, drawn_by, told)

    def closest(
        self, state: ThesisState, sampled: SurfacePoints, tree: scipy.spatial.cKDTree
    ) -> Projection:
        """Pair every model point with the nearest measured one: the operator C (2.3)."""
        predicted = self.setup.body.frames(state.pose).apply(sampled.part, sampled.points)
        distance, index = tree.query(predicted)
        measured: FloatArray = np.asarray(tree.data)[index]
        apart = distance > 1e-12
        joined = np.where(apart[:, None], measured - predicted, 0.0)
        e = joined / np.where(apart, distance, 1.0)[:, None]
        return Projection(sampled, sampled[apart], predicted[apart], measured[apart], e[apart])

    def correct(
        self, state: ThesisState, pairs: Projection, recorder: StepRecorder | None = None
    ) -> tuple[ThesisState, float]:
        """Correct x and P by the unscented transform; also returns the normalised innovation."""
        if recorder is not None:
            recorder.paired()
        weights = self.setup.weights
        dX = sigma_deviations(state.P, weights)
        X = pose_of_state(state.x + dX, THESIS_JOINTS)
        Y = pairs.z_hat(self.setup.body.frames(X))
        z_hat = weights.mean @ Y
        nu, dY = pairs.z - z_hat, Y - z_hat
        R = np.full(len(nu), self.setup.parameters.sigma_measurement**2)
        P_zz = np.einsum("s,sm,sm->m", weights.covariance, dY, dY)
        dx, P = correct(state.P, dX, dY, weights.covariance, nu, R)
        after = replace(state, x=state.x + dx, P=P)
        if recorder is not None:
            recorder.unscented(state.belief, after.belief, dx, pairs, SigmaPoints(dX, X), Y)
        return after, normalised(nu, P_zz + R)

    def _found(self, state: ThesisState, pairs: Projection, innovation: float) -> Estimate:
        pose = state.pose
        model = self.setup.body.frames(pose).apply(pairs.sampled.part, pairs.sampled.points)
        distance = np.einsum("mi,mi->m", pairs.e, pairs.measured - model)
        sigma = np.full(len(model), self.setup.parameters.sigma_measurement)
        matched = pairs.sampled.part, pairs.measured, model, pairs.e
        return Estimate(
            tracked=True,
            reason="",
            pose=pose,
            x=state.x.copy(),
            P=state.P.copy(),
            residual=float(np.sqrt(np.mean(distance**2))),
            innovation=innovation,
            correspondences=Correspondences(*matched, distance, sigma, np.ones(len(model))),
        )


def _lost(state: ThesisState, reason: str) -> tuple[ThesisState, Estimate]:
    """State a frame in which nothing could be measured."""
    return state, Estimate(False, reason, state.pose, state.x.copy(), state.P.copy())


def _random_state(rng: np.random.Generator) -> NDArray[np.uint8]:
    return np.frombuffer(json.dumps(rng.bit_generator.state).encode(), dtype=np.uint8)


def _random_of(state: NDArray[np.uint8]) -> np.random.Generator:
    rng = np.random.default_rng(0)
    rng.bit_generator.state = json.loads(state.tobytes())
    return rng
