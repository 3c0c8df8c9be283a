"""The tracker of the thesis (chapter 3): model points look for the nearest measured ones."""

from __future__ import annotations

import json
import time
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.angles import THESIS_JOINTS, pose_of_state, state_names, state_of_pose
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.body.sampling import SurfacePoints, visible_points
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.filtering.correction import correct, normalised
from stereotrack_core.filtering.sigma_points import scaled_weights, sigma_deviations
from stereotrack_core.tracking.collisions import Clearance, collisions_avoided
from stereotrack_core.tracking.confidence import unexplained_fraction_of
from stereotrack_core.tracking.estimate import (
    OVERCONFIDENCE,
    Correspondences,
    Estimate,
    Memory,
    Prior,
    limb_sigma_deg,
)
from stereotrack_core.tracking.inside.observer import SILENT, Observer
from stereotrack_core.tracking.lost.judge import lost_probability
from stereotrack_core.tracking.lost.signs import Judged, limb_signs, unexpected
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.process import elapsed, process_noise, time_array, time_in


@dataclass(frozen=True, eq=False)
class Projection:
    """Pairs of points, each projected on the line that joins them, (3.5) to (3.8).

    Attributes
    ----------
    sampled : SurfacePoints
        Model points, fixed to their parts.
    predicted : (m, 3) float64, world
        The model points at x_hat: p_zhat.
    measured : (m, 3) float64, world
        Their nearest measured points: p_z.
    e : (m, 3) float64
        Unit vectors from p_zhat to p_z, evaluated once at x_hat. With directions recomputed for
        every sigma point the tracker is destroyed.
    """

    sampled: SurfacePoints
    predicted: FloatArray
    measured: FloatArray
    e: FloatArray

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

    Parameters
    ----------
    body : BodyModel
    parameters : TrackingParameters
    cameras : (V, 3) float64, world, metres
        Optical centres of the views.
    fps : float
        Frame sets per second; the process noise is stated for 10 Hz.
    seed : int
        Of the random sampling.

    Attributes
    ----------
    observer : Observer
        Is told what happens inside a frame.
    """

    observer: Observer = SILENT

    state_names = state_names(THESIS_JOINTS)

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
        self.Q = process_noise(parameters, THESIS_JOINTS, fps)
        self._rng = np.random.default_rng(seed)
        self._clearance = Clearance(parameters.clearance, np.radians(parameters.least_elbow_angle))
        p = parameters
        self._weights = scaled_weights(len(self.Q), p.ut_alpha, p.ut_beta, p.ut_kappa)
        self.x = np.zeros(len(self.Q))
        self.P = self.Q.copy()
        self._prior: Prior | None = None
        self._movement = np.zeros(len(self.Q))
        self._time: float | None = None
        self._anew = True

    def start(self, pose: Pose) -> None:
        """Begin from a pose, as uncertain as one step of the process makes it."""
        self.x = state_of_pose(pose, THESIS_JOINTS)
        self.P = self.Q.copy()
        self._time = None
        self._anew = True

    def step(self, cloud: Cloud) -> Estimate:
        """Follow to the next cloud (3.2.3 and 3.2.4)."""
        begun, before = time.perf_counter(), self.x
        self.predict(cloud.frame)
        self.observer.predicted_state(self.x, self.P)
        carried = np.ones(len(self.x), dtype=np.bool_)
        self._prior = None if self._anew else Prior(np.zeros(len(self.x)), self.P, carried)
        if len(cloud.points) < self.parameters.least_points:
            return self.lost(f"the cloud has only {len(cloud.points)} points")
        tree = cKDTree(cloud.points, balanced_tree=False, compact_nodes=False)
        innovations = []
        for _ in range(self.parameters.iterations):
            sampled = self.sample()
            if not len(sampled):
                return self.lost("no part of the body is in sight of any camera")
            pairs = self.closest(sampled, tree)
            if not len(pairs.e):
                return self.lost("every model point lies on its measured point")
            self.observer.paired(sampled, pairs)
            innovations.append(self.correct(pairs))
            self.observer.corrected_state(self.x, self.P)
        self.avoid_collisions()
        self.observer.avoided(self.x)
        self._anew = False
        self._movement = self.x - before
        self._movement[3:] = np.arctan2(np.sin(self._movement[3:]), np.cos(self._movement[3:]))
        return self.estimate(cloud, pairs, innovations[0], time.perf_counter() - begun)

    def memory(self) -> Memory:
        """All that the next step depends on; see :class:`Tracker`."""
        drawn = json.dumps(self._rng.bit_generator.state)
        return {
            "x": self.x,
            "P": self.P,
            "movement": self._movement,
            "time": time_array(self._time),
            "anew": np.array(self._anew),
            "random": np.frombuffer(drawn.encode(), dtype=np.uint8),
        }

    def recall(self, memory: Memory) -> None:
        """Go on as the tracker would whose memory this is."""
        self.x, self.P, self._time = memory["x"], memory["P"], time_in(memory["time"])
        self._movement, self._anew = memory["movement"], bool(memory["anew"])
        self._rng.bit_generator.state = json.loads(memory["random"].tobytes())

    def predict(self, time: float) -> None:
        """Predict that the body stays where it is, with more uncertainty (3.2.1)."""
        self.P = self.P + elapsed(self._time, time) * self.Q
        self._time = time

    def sample(self) -> SurfacePoints:
        """Draw the model points G(x_hat), (3.4)."""
        frames = self.body.frames(pose_of_state(self.x, THESIS_JOINTS))
        rng = self._rng if self.parameters.sampling == "random" else None
        wanted, watch = self.parameters.model_points, self.observer.sampled
        return visible_points(self.body, frames, self.cameras, wanted, rng, watch)

    def closest(self, sampled: SurfacePoints, tree: cKDTree) -> Projection:
        """Pair every model point with the nearest measured one: the operator C (2.3)."""
        frames = self.body.frames(pose_of_state(self.x, THESIS_JOINTS))
        predicted = frames.apply(sampled.part, sampled.points)
        distance, index = tree.query(predicted)
        measured: FloatArray = np.asarray(tree.data)[index]
        apart = distance > 1e-12
        joined = np.where(apart[:, None], measured - predicted, 0.0)
        e = joined / np.where(apart, distance, 1.0)[:, None]
        return Projection(sampled[apart], predicted[apart], measured[apart], e[apart])

    def correct(self, pairs: Projection) -> float:
        """Correct state and covariance by the unscented transform; returns its innovation."""
        dX = sigma_deviations(self.P, self._weights)
        Y = pairs.z_hat(self.body.frames(pose_of_state(self.x + dX, THESIS_JOINTS)))
        z_hat = self._weights.mean @ Y
        nu = pairs.z - z_hat
        R = np.full(len(nu), self.parameters.sigma_measurement**2)
        P_zz = np.einsum("s,sm,sm->m", self._weights.covariance, Y - z_hat, Y - z_hat)
        corrected = correct(self.P, dX, Y - z_hat, self._weights.covariance, nu, R)
        self.x = self.x + corrected.dx
        self.P = corrected.P
        return normalised(nu, P_zz + R)

    def avoid_collisions(self) -> None:
        """Set the arms to a pose that keeps the least distances (3.2.4)."""
        pose = pose_of_state(self.x, THESIS_JOINTS)
        free = collisions_avoided(self.body, pose, self._clearance)
        self.x = np.append(self.x[:6], state_of_pose(free, THESIS_JOINTS)[6:])

    def lost(self, reason: str) -> Estimate:
        """State a frame in which nothing could be measured."""
        pose = pose_of_state(self.x, THESIS_JOINTS)
        return Estimate(False, reason, pose, self.x.copy(), self.P.copy())

    def estimate(
        self, cloud: Cloud, pairs: Projection, innovation: float, seconds: float
    ) -> Estimate:
        """State the pose with the signs by which it can be judged."""
        pose = pose_of_state(self.x, THESIS_JOINTS)
        frames = self.body.frames(pose)
        model = frames.apply(pairs.sampled.part, pairs.sampled.points)
        distance = np.einsum("mi,mi->m", pairs.e, pairs.measured - model)
        dX = sigma_deviations(self.P, self._weights)
        spread = self.body.frames(pose_of_state(self.x + dX, THESIS_JOINTS))
        begun = time.perf_counter()
        sigma = limb_sigma_deg(spread, self._weights.covariance)
        joined = Correspondences(pairs.measured, model, pairs.sampled.part, np.ones(len(model)))
        share = unexplained_fraction_of(cloud.points, self.body, frames)
        jump = unexpected(self._movement, self._prior, THESIS_JOINTS)
        judged = Judged(pose, frames, sigma, share, joined, jump)
        signs = limb_signs(cloud, self.body, judged)
        return Estimate(
            tracked=True,
            reason="",
            pose=pose,
            x=self.x.copy(),
            P=self.P.copy(),
            unexplained_fraction=share,
            residual=float(np.sqrt(np.mean(distance**2))),
            innovation=innovation,
            limb_sigma_deg=OVERCONFIDENCE * sigma,
            limb_lost=lost_probability(signs),
            limb_signs=signs,
            correspondences=joined,
            seconds={"track": seconds, "judge": time.perf_counter() - begun},
            prior=self._prior,
        )
