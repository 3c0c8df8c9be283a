"""The tracker of the thesis (chapter 3): model points look for the nearest measured ones."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import scipy

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.angles import THESIS_JOINTS, pose_of_state, state_names, state_of_pose
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.body.sampling import SurfacePoints, visible_points
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.filtering.correction import correct, normalised
from stereotrack_core.filtering.sigma_points import sigma_deviations
from stereotrack_core.tracking.estimate import Correspondences, Estimate, Memory, Prior
from stereotrack_core.tracking.failure.features import Evidence, judged
from stereotrack_core.tracking.residuals.limits import LEAST_ELBOW_ANGLE
from stereotrack_core.tracking.state import Belief, Setup, elapsed, time_array, time_in
from stereotrack_core.tracking.step_recorder import StepRecorder
from stereotrack_core.tracking.thesis_collisions import collisions_avoided
from stereotrack_core.tracking.trace import SigmaPoints


@dataclass(frozen=True, eq=False)
class Projection:
    """Pairs of points, each projected on the line that joins them, (3.5) to (3.8)."""

    drawn: SurfacePoints
    sampled: SurfacePoints
    """`drawn` and `sampled`: model points, fixed to their parts: all, and those that do not lie on
    their partner."""
    predicted: FloatArray
    """(m, 3), world. The model points at x_hat: p_zhat."""
    measured: FloatArray
    """(m, 3), world. Their nearest measured points: p_z."""
    e: FloatArray
    """(m, 3). Unit vectors from p_zhat to p_z, evaluated once at x_hat. With directions recomputed
    for every sigma point the tracker is destroyed."""

    @property
    def z(self) -> FloatArray:
        """The measurement vector (m,): (3.6) and (3.8)."""
        result: FloatArray = np.einsum("mi,mi->m", self.e, self.measured)
        return result

    def z_hat(self, frames: PartFrames) -> FloatArray:
        """Predicted measurements (S, m) of stacked poses: (3.5), (3.7) and (3.11)."""
        rotations = frames.rotations[:, self.sampled.part]
        points = np.einsum("smij,mj->smi", rotations, self.sampled.points)
        points += frames.origins[:, self.sampled.part]
        result: FloatArray = np.einsum("mi,smi->sm", self.e, points)
        return result


class ThesisTracker:
    """Predict, then correct i times by closest points, then avoid collisions.

    Attributes
    ----------
    x : (n,) float64
        State: position and Euler angles, :data:`state_names`.
    P : (n, n) float64
        Its covariance.
    """

    state_names = state_names(THESIS_JOINTS)

    def __init__(self, setup: Setup) -> None:
        self.setup = setup
        self.P = self.Q = setup.Q
        self.x = np.zeros(len(self.Q))
        self._rng = np.random.default_rng(setup.seed)
        self._time: float | None = None
        self._anew = True

    @property
    def pose(self) -> Pose:
        """The pose that the state stands for."""
        return pose_of_state(self.x, THESIS_JOINTS)

    @property
    def belief(self) -> Belief:
        """Its pose with the covariance of the state."""
        return Belief(self.pose, self.P)

    def start(self, pose: Pose, *, P: FloatArray | None = None) -> None:
        """Begin from a pose, as uncertain as stated or as one step of the process makes it."""
        self.x = state_of_pose(pose, THESIS_JOINTS)
        self._anew = P is None or P.shape != self.Q.shape
        self.P = self.Q if P is None or self._anew else P.copy()
        self._time = None

    def step(self, cloud: Cloud, trace: StepRecorder | None = None) -> Estimate:
        """Follow to the next cloud (3.2.3 and 3.2.4)."""
        begun, x, before, p = time.perf_counter(), self.x, self.belief, self.setup.parameters
        self.predict(cloud.frame)
        predicted = self.x, self.P
        if trace is not None:
            trace.predicted(before, self.belief)
        prior = None if self._anew else Prior(self.P, np.ones(len(x), np.bool_))
        if len(cloud.points) < p.least_points:
            return self.lost(f"the cloud has only {len(cloud.points)} points")
        tree = scipy.spatial.cKDTree(cloud.points, balanced_tree=False, compact_nodes=False)
        innovations = []
        for _ in range(p.iterations):
            sampled = self.sample(trace)
            if not len(sampled):
                self.x, self.P = predicted
                return self.lost("no part of the body is visible in any camera")
            pairs = self.closest(sampled, tree)
            if not len(pairs.e):
                self.x, self.P = predicted
                return self.lost("every model point coincides with its measured point")
            innovations.append(self.correct(pairs, trace))
        self.avoid_collisions(trace)
        self._anew = False
        seconds = {"track": time.perf_counter() - begun}
        found = self._found(pairs, innovations[0], prior, seconds)
        spread = pose_of_state(self.x + sigma_deviations(self.P, self.setup.weights), THESIS_JOINTS)
        evidence = Evidence(spread, _angles_wrapped(self.x - x))
        return judged(found, cloud, self.setup, evidence)

    def predict(self, time: float) -> None:
        """Predict that the body stays where it is, with more uncertainty (3.2.1)."""
        self.P = self.P + elapsed(self._time, time) * self.Q
        self._time = time

    def sample(self, trace: StepRecorder | None = None) -> SurfacePoints:
        """Draw the model points G(x_hat), (3.4)."""
        setup, p = self.setup, self.setup.parameters
        rng = self._rng if p.sampling == "random" else None
        frames, told = setup.body.frames(self.pose), None if trace is None else trace.sampled
        return visible_points(setup.body, frames, setup.cameras, p.model_points, rng, told)

    def closest(self, sampled: SurfacePoints, tree: scipy.spatial.cKDTree) -> Projection:
        """Pair every model point with the nearest measured one: the operator C (2.3)."""
        predicted = self.setup.body.frames(self.pose).apply(sampled.part, sampled.points)
        distance, index = tree.query(predicted)
        measured: FloatArray = np.asarray(tree.data)[index]
        apart = distance > 1e-12
        joined = np.where(apart[:, None], measured - predicted, 0.0)
        e = joined / np.where(apart, distance, 1.0)[:, None]
        return Projection(sampled, sampled[apart], predicted[apart], measured[apart], e[apart])

    def correct(self, pairs: Projection, trace: StepRecorder | None = None) -> float:
        """Correct state and covariance by the unscented transform; returns its innovation."""
        if trace is not None:
            trace.paired()
        weights, before = self.setup.weights, self.belief
        dX = sigma_deviations(self.P, weights)
        X = pose_of_state(self.x + dX, THESIS_JOINTS)
        Y = pairs.z_hat(self.setup.body.frames(X))
        z_hat = weights.mean @ Y
        nu, dY = pairs.z - z_hat, Y - z_hat
        R = np.full(len(nu), self.setup.parameters.sigma_measurement**2)
        P_zz = np.einsum("s,sm,sm->m", weights.covariance, dY, dY)
        corrected = correct(self.P, dX, dY, weights.covariance, nu, R)
        self.x = self.x + corrected.dx
        self.P = corrected.P
        if trace is not None:
            sigma_points = SigmaPoints(dX, X)
            trace.unscented(before, self.belief, corrected.dx, pairs, sigma_points, dY, nu, R)
        return normalised(nu, P_zz + R)

    def avoid_collisions(self, trace: StepRecorder | None = None) -> None:
        """Set the arms to a pose that keeps the least distances (3.2.4)."""
        p = self.setup.parameters
        least = p.clearance, LEAST_ELBOW_ANGLE
        jump = collisions_avoided(self.setup.body, self.pose, *least)
        self.x = np.append(self.x[:6], state_of_pose(jump.after, THESIS_JOINTS)[6:])
        if trace is not None:
            trace.avoided(replace(jump, after=self.pose))

    def lost(self, reason: str) -> Estimate:
        """State a frame in which nothing could be measured."""
        return Estimate(False, reason, self.pose, self.x.copy(), self.P.copy())

    def memory(self) -> Memory:
        """All that the next step depends on; see :class:`Tracker`."""
        drawn = json.dumps(self._rng.bit_generator.state)
        return {
            "x": self.x,
            "P": self.P,
            "time": time_array(self._time),
            "anew": np.array(self._anew),
            "random": np.frombuffer(drawn.encode(), dtype=np.uint8),
        }

    def recall(self, memory: Memory) -> None:
        """Go on as the tracker would whose memory this is."""
        self.x, self.P, self._time = memory["x"], memory["P"], time_in(memory["time"])
        self._anew = bool(memory["anew"])
        self._rng.bit_generator.state = json.loads(memory["random"].tobytes())

    def _found(
        self,
        pairs: Projection,
        innovation: float,
        prior: Prior | None,
        seconds: Mapping[str, float],
    ) -> Estimate:
        pose = self.pose
        model = self.setup.body.frames(pose).apply(pairs.sampled.part, pairs.sampled.points)
        distance = np.einsum("mi,mi->m", pairs.e, pairs.measured - model)
        sigma = np.full(len(model), self.setup.parameters.sigma_measurement)
        matched = pairs.sampled.part, pairs.measured, model, pairs.e
        return Estimate(
            tracked=True,
            reason="",
            pose=pose,
            x=self.x.copy(),
            P=self.P.copy(),
            residual=float(np.sqrt(np.mean(distance**2))),
            innovation=innovation,
            correspondences=Correspondences(*matched, distance, sigma, np.ones(len(model))),
            seconds=seconds,
            prior=prior,
        )


def _angles_wrapped(dx: FloatArray) -> FloatArray:
    """A change of the state (n,) whose angles lie between -pi and pi."""
    return np.append(dx[:3], np.arctan2(np.sin(dx[3:]), np.cos(dx[3:])))
