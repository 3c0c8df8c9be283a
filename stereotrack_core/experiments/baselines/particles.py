"""The annealed particle filter, and how badly many poses at once explain data, as a baseline."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.manifold import difference, displaced
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import PartFrames, Pose, t_pose
from stereotrack_core.body.skeleton import CLAVICLES, FOREARMS, PARENTS, TORSO
from stereotrack_core.body.surface import closest_on_cone, cone_tables
from stereotrack_core.compiled import compiled
from stereotrack_core.experiments.baselines.estimators import RANDOM, Baseline
from stereotrack_core.tracking.correction import Residual
from stereotrack_core.tracking.estimate import Memory
from stereotrack_core.tracking.estimator import Measurements, Prediction
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.residuals.limits import (
    LEAST_ELBOW_ANGLE,
    limit_residuals,
    resting_limbs,
    shoulders_at_rest,
)
from stereotrack_core.tracking.residuals.surface import FIRST_LOSS
from stereotrack_core.tracking.state import Belief

PARTICLES, LAYERS = 200, 10
"""As many as the paper's, which tracks fewer numbers with more views."""

_SURVIVAL = 0.2
"""Share of the particles that survives a layer."""

_DIFFUSION = 0.3
"""Diffusion between two layers, in standard deviations of the particles."""

_DATA = 300
"""Measured points that each particle is weighed by."""

_LEAST_SIGMA = 1e-4
"""Metres and radians; particles that all agree are not taken for certainty."""


_ELSEWHERE = 0.5
"""Length of the error state by which the pose may differ from where the particles left it; beyond,
somebody was found again elsewhere and the particles are of no use."""


class AnnealedParticles(Baseline):
    """Particles that are weighed in layers (Deutscher, Blake, Reid, DOI 10.1109/CVPR.2000.854758).

    Every layer weighs the particles by exp(-beta E), with beta such that the wanted share of them
    survives, and draws them anew by their weights. E is the tracker's own measure; see
    :class:`PoseEnergy`; colours say nothing in it. Between two layers limbs are exchanged among
    the particles, and each number is scattered in proportion to how far the particles still
    disagree about it (Deutscher, Reid, DOI 10.1023/B:VISI.0000043757.18370.9c); without these two,
    28 numbers are too many for some hundred particles. The pose is the weighted mean of the last
    layer, whose particles go on to the next frame.
    """

    def begin(self, pose: Pose) -> None:
        """Draw the next frame's particles around its prediction."""
        self._particles: FloatArray | None = None
        self._centre = self._left = pose

    def memory(self) -> Memory:
        """The particles."""
        if self._particles is None:
            return {}
        return {
            "particles": self._particles,
            "centre_position": self._centre.position,
            "centre_rotations": self._centre.rotations,
            "left_position": self._left.position,
            "left_rotations": self._left.rotations,
        }

    def recall(self, memory: Memory) -> None:
        """Restore saved particles; none were there before the first frame."""
        self._particles = memory.get("particles")
        if self._particles is not None:
            self._centre = Pose(memory["centre_position"], memory["centre_rotations"])
            self._left = Pose(memory["left_position"], memory["left_rotations"])

    def settle(self, measured: Measurements, predicted: Prediction) -> Belief:
        """Scatter, weigh and draw the particles, layer by layer."""
        setup, rng = self.setup, measured.random(RANDOM)
        energy = PoseEnergy(setup.body, setup.parameters, setup.joints)
        data = measured.data[:, :3]
        if len(data) > _DATA:
            data = data[np.sort(rng.choice(len(data), _DATA, replace=False))]
        particles, beta, pose = self._scattered(predicted, rng), 0.0, predicted.pose
        for layer in range(LAYERS):
            if layer:
                particles = limbs_exchanged(particles, self._limbs(), rng)
                scatter = _DIFFUSION * particles.std(axis=0)
                particles = particles + scatter * rng.normal(size=particles.shape)
            E = energy.of(data, predicted.pose, particles, measured.beside(pose))
            beta = max(beta, exponent(E, _SURVIVAL))
            weights = normalised(E, beta)
            mean, weighed = weights @ particles, particles
            pose = displaced(predicted.pose, mean, setup.joints)
            particles = particles[systematic(weights, float(rng.random()))]
        off = weighed - mean
        self._particles, self._centre, self._left = particles, predicted.pose, pose
        return Belief(pose, (off.T * weights) @ off + _LEAST_SIGMA**2 * np.eye(len(predicted.P)))

    def _scattered(self, predicted: Prediction, rng: np.random.Generator) -> FloatArray:
        """Particles (K, n) as displacements of the predicted pose, before the first layer."""
        setup, P0 = self.setup, predicted.P
        taken_elsewhere = difference(predicted.pose, self._left, setup.joints)
        if self._particles is None or np.linalg.norm(taken_elsewhere) > _ELSEWHERE:
            drawn = rng.normal(size=(PARTICLES, len(P0)))
            result: FloatArray = drawn @ np.linalg.cholesky(P0).T
            return result
        seen = displaced(self._centre, self._particles, setup.joints)
        moved = [
            difference(seen[k], predicted.pose, setup.joints) for k in range(len(self._particles))
        ]
        scatter = np.sqrt(predicted.gone * np.diagonal(setup.Q))
        return np.array(moved) + scatter * rng.normal(size=self._particles.shape)

    def _limbs(self) -> list[IntArray]:
        """Columns of each chain of parts that hangs on the torso."""
        chains: dict[int, list[int]] = {}
        for joint in self.setup.joints:
            root = joint
            while PARENTS[root] != TORSO:
                root = PARENTS[root]
            at = int(self.setup.columns.first[joint])
            chains.setdefault(root, []).extend((at, at + 1))
        return [np.array(columns) for columns in chains.values()]


def limbs_exchanged(
    particles: FloatArray, limbs: list[IntArray], rng: np.random.Generator
) -> FloatArray:
    """Particles (K, n) each of whose limbs, given by their columns, comes from some particle."""
    result = particles.copy()
    for columns in limbs:
        result[:, columns] = particles[rng.permutation(len(particles))][:, columns]
    return result


def survival(E: FloatArray, beta: float) -> float:
    """Share (0 to 1) of particles with energies E that weights exp(-beta E) let survive.

    (sum w)^2 / (K sum w^2), the survival diagnostic of the paper's section 4.
    """
    w = np.exp(-beta * (E - E.min()))
    return float(w.sum() ** 2 / (len(w) * (w @ w)))


def exponent(E: FloatArray, wanted: float) -> float:
    """Exponent beta with which the wanted share survives; found in its logarithm."""
    spread = float(np.ptp(E))
    if not spread > 0.0:
        return 0.0
    low, high = np.log(1e-6 / spread), np.log(1e6 / spread)
    if survival(E, float(np.exp(high))) > wanted:
        return float(np.exp(high))
    root = scipy.optimize.brentq(lambda log: survival(E, float(np.exp(log))) - wanted, low, high)
    return float(np.exp(root))


def normalised(E: FloatArray, beta: float) -> FloatArray:
    """Weights (K,) exp(-beta E), which sum up to 1."""
    w = np.exp(-beta * (E - E.min()))
    result: FloatArray = w / w.sum()
    return result


def systematic(weights: FloatArray, offset: float) -> IntArray:
    """Indices (K,) drawn by weights at K evenly spaced places, shifted by one random number."""
    places = (np.arange(len(weights)) + offset) / len(weights)
    cumulated = np.cumsum(weights)
    return np.minimum(np.searchsorted(cumulated, places, side="right"), len(weights) - 1)


_ALONG = np.linspace(0.0, 1.0, 4)
"""Places along a forearm that may come close to the torso."""

_SLACK = 0.01
"""Metres by which an arm that is asked about its limits may be farther away than they say."""


class PoseEnergy:
    """Negative logarithm of the likelihood of poses, up to a constant.

    A datum at distance e from the surface counts g^2 e^2 / (2 (g^2 + e^2)) over its variance:
    the function whose derivative is the tracker's weight (g^2 / (g^2 + e^2))^2 times e. To this
    come half the squares of the limits' rows over their variances.
    """

    def __init__(
        self, body: BodyModel, parameters: TrackingParameters, joints: tuple[int, ...]
    ) -> None:
        self.body = body
        self.parameters = parameters
        self.joints = joints
        self._always = resting_limbs(joints)
        self._has_girdle = CLAVICLES[0] in joints
        # Nothing is violated in the T pose: as many rows come first in every pose.
        self._resting = len(limit_residuals(body, t_pose(np.zeros(3)), parameters, joints))

    def of(
        self,
        data: FloatArray,
        centre: Pose,
        deltas: FloatArray,
        beside: Sequence[Residual] = (),
    ) -> FloatArray:
        """Energies (K,) of the poses that displacements (K, n) of `centre` lead to.

        Parameters
        ----------
        data : (N, 3) float64, world
        deltas : (K, n) float64
        beside : sequence of Residual
            Of other sensors, paired at a pose amid the others.
        """
        p = self.parameters
        poses = displaced(centre, deltas, self.joints)
        frames = self.body.frames(poses)
        tables = cone_tables(self.body.cones, frames)
        result = np.empty(len(deltas))
        _robust_sums(
            np.ascontiguousarray(data),
            tables,
            p.max_correspondence_distance,
            (FIRST_LOSS * p.loss_scale) ** 2,
            result,
        )
        crowd = max(1.0, len(data) / p.effective_sample_size)
        result /= p.sigma_measurement**2 * crowd
        for residual in (*beside, *self._always):
            nu = residual.measured - residual.predicted(frames)
            result += 0.5 * np.sum(nu**2 / residual.variance, axis=1)
        if self._has_girdle:
            off, variance = shoulders_at_rest(poses.rotations)
            result += 0.5 * np.sum(off**2 / variance, axis=1)
        for k in np.flatnonzero(self._suspected(frames, tables, poses)).tolist():
            result[k] += self._violations(poses[k], frames, k)
        return result

    def _suspected(self, frames: PartFrames, tables: FloatArray, poses: Pose) -> BoolArray:
        """Poses (K,) whose elbows may be folded too far, or whose forearms are at the torso."""
        arms = list(FOREARMS)
        straight = poses.rotations[:, arms][:, :, 2, 2].min(axis=1)
        folded = straight < -np.cos(LEAST_ELBOW_ANGLE)
        if self.parameters.clearance <= 0.0:
            return np.asarray(folded)
        along = frames.rotations[:, arms][..., 2] * self.body.skeleton.lengths[arms][:, None]
        places = frames.origins[:, arms, None] + _ALONG[:, None] * along[:, :, None]
        distance = np.empty(len(tables))
        _least_distances(places.reshape(len(tables), -1, 3), tables[:, 0].copy(), distance)
        return np.asarray(folded | (distance < self.parameters.clearance + _SLACK))

    def _violations(self, pose: Pose, frames: PartFrames, k: int) -> float:
        own = PartFrames(frames.rotations[k : k + 1], frames.origins[k : k + 1])
        rows = limit_residuals(self.body, pose, self.parameters, self.joints)
        total = 0.0
        for residual in rows[self._resting :]:
            nu = residual.measured - residual.predicted(own)[0]
            total += 0.5 * float(np.sum(nu**2 / residual.variance))
        return total


@compiled(inline="always")
def _distance(row: Any, p: Any) -> float:
    x, y, z = p[0] - row[9], p[1] - row[10], p[2] - row[11]
    px = row[0] * x + row[3] * y + row[6] * z
    py = row[1] * x + row[4] * y + row[7] * z
    pz = row[2] * x + row[5] * y + row[8] * z
    return closest_on_cone(row, px, py, pz)[0]  # type: ignore[no-any-return]


@compiled()
def _robust_sums(points: Any, tables: Any, reach: float, squared_scale: float, out: Any) -> None:
    for k in range(tables.shape[0]):
        total = 0.0
        for i in range(points.shape[0]):
            nearest = reach
            for c in range(tables.shape[1]):
                nearest = min(nearest, abs(_distance(tables[k, c], points[i])))
            e = nearest * nearest
            total += 0.5 * squared_scale * e / (squared_scale + e)
        out[k] = total


@compiled()
def _least_distances(places: Any, rows: Any, out: Any) -> None:
    for k in range(rows.shape[0]):
        least = 1e9
        for i in range(places.shape[1]):
            least = min(least, _distance(rows[k], places[k, i]))
        out[k] = least
