"""The annealed particle filter, and how badly many poses at once explain data, as a baseline."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.manifold import REST_ROW, difference, displaced
from stereotrack_core.body.model import PlacedCones, placed_cones
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.body.skeleton import FOREARMS, PARENTS, TORSO
from stereotrack_core.body.surface import closest_on_cone, in_cone
from stereotrack_core.compiled import compiled
from stereotrack_core.experiments.baselines.estimators import RANDOM
from stereotrack_core.tracking.correction import Residual
from stereotrack_core.tracking.measurements import Measurements
from stereotrack_core.tracking.residuals import limits
from stereotrack_core.tracking.residuals.surface import FIRST_LOSS
from stereotrack_core.tracking.state import Belief, Particles, Setup, State, elapsed

PARTICLES, LAYERS = 200, 10  # as many as the paper's, which tracks fewer numbers with more views
_SURVIVAL = 0.2  # share of the particles that survives a layer
_DIFFUSION = 0.3  # diffusion between two layers, in standard deviations of the particles
_DATA = 300  # measured points that each particle is weighed by
_LEAST_SIGMA = 1e-4  # metres and radians; particles that all agree are not taken for certainty


_ELSEWHERE = 0.5
"""Length of the error state by which the pose may differ from where the particles left it; beyond,
somebody was found again elsewhere and the particles are of no use."""


def annealed_particles(
    measured: Measurements, predicted: Belief, before: State
) -> tuple[Belief, Particles]:
    """Particles that are weighed in layers (Deutscher, Blake, Reid, DOI 10.1109/CVPR.2000.854758).

    Every layer weighs the particles by exp(-beta E), with beta such that the wanted share of them
    survives, and draws them anew by their weights. E is the tracker's own measure; see
    :func:`energies`; colours say nothing in it. Between two layers limbs are exchanged among
    the particles, and each number is scattered in proportion to how far the particles still
    disagree about it (Deutscher, Reid, DOI 10.1023/B:VISI.0000043757.18370.9c); without these two,
    28 numbers are too many for some hundred particles. The pose is the weighted mean of the last
    layer, whose particles go on to the next frame.
    """
    setup, rng, data = measured.setup, measured.random(RANDOM), measured.data[:, :3]
    if len(data) > _DATA:
        data = data[np.sort(rng.choice(len(data), _DATA, replace=False))]
    gone = elapsed(before.time, measured.cloud.frame)
    particles = _scattered(setup, predicted, before.particles, gone, rng)
    beta, pose, chains = 0.0, predicted.pose, _chains(setup)
    for layer in range(LAYERS):
        if layer:
            particles = _limbs_exchanged(particles, chains, rng)
            scatter = _DIFFUSION * particles.std(axis=0)
            particles = particles + scatter * rng.normal(size=particles.shape)
        E = energies(setup, data, predicted.pose, particles, measured.beside(pose))
        beta = max(beta, exponent(E, _SURVIVAL))
        weights = normalised(E, beta)
        mean, weighed = weights @ particles, particles
        pose = displaced(predicted.pose, mean, setup.joints)
        particles = particles[_systematic(weights, float(rng.random()))]
    off = weighed - mean
    P = (off.T * weights) @ off + _LEAST_SIGMA**2 * np.eye(len(predicted.P))
    return Belief(pose, P), Particles(particles, predicted.pose, pose)


def _scattered(
    setup: Setup, predicted: Belief, last: Particles | None, gone: float, rng: np.random.Generator
) -> FloatArray:
    """Particles (K, n) as displacements of the predicted pose, before the first layer."""
    P0, joints = predicted.P, setup.joints
    if last is None or np.linalg.norm(difference(predicted.pose, last.pose, joints)) > _ELSEWHERE:
        drawn = rng.normal(size=(PARTICLES, len(P0)))
        result: FloatArray = drawn @ np.linalg.cholesky(P0).T
        return result
    seen = displaced(last.centre, last.displacements, joints)
    moved = [difference(seen[k], predicted.pose, joints) for k in range(PARTICLES)]
    scatter = np.sqrt(gone * np.diagonal(setup.Q))
    return np.array(moved) + scatter * rng.normal(size=last.displacements.shape)


def _chains(setup: Setup) -> list[IntArray]:
    """Columns of each chain of parts that hangs on the torso."""
    chains: dict[int, list[int]] = {}
    for joint in setup.joints:
        root = joint
        while PARENTS[root] != TORSO:
            root = PARENTS[root]
        at = int(setup.columns.first[joint])
        chains.setdefault(root, []).extend((at, at + 1))
    return [np.array(columns) for columns in chains.values()]


def _limbs_exchanged(
    particles: FloatArray, limbs: list[IntArray], rng: np.random.Generator
) -> FloatArray:
    """Particles (K, n) each of whose limbs, given by their columns, comes from some particle."""
    result = particles.copy()
    for columns in limbs:
        result[:, columns] = particles[rng.permutation(len(particles))][:, columns]
    return result


def survival(E: FloatArray, beta: float) -> float:
    """Share (sum w)^2 / (K sum w^2) of particles that weights exp(-beta E) let survive."""
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


def _systematic(weights: FloatArray, offset: float) -> IntArray:
    """Indices (K,) drawn by weights at K evenly spaced places, shifted by one random number."""
    places = (np.arange(len(weights)) + offset) / len(weights)
    cumulated = np.cumsum(weights)
    return np.minimum(np.searchsorted(cumulated, places, side="right"), len(weights) - 1)


_ALONG = np.linspace(0.0, 1.0, 4)  # places along a forearm that may come close to the torso
_SLACK = 0.01  # metres beyond the limits at which an arm is still asked about them


def energies(
    setup: Setup, data: FloatArray, centre: Pose, deltas: FloatArray, beside: Sequence[Residual]
) -> FloatArray:
    """Negative logarithms (K,) of the likelihood of displacements (K, n) of a pose, but a constant.

    A datum (N, 3), world, at distance e from the surface counts g^2 e^2 / (2 (g^2 + e^2)) over its
    variance: the function whose derivative is the tracker's weight (g^2 / (g^2 + e^2))^2 times e.
    To this come half the squares of the limits' and the sensors' rows over their variances.
    """
    p, body, joints = setup.parameters, setup.body, setup.joints
    poses = displaced(centre, deltas, joints)
    frames = body.frames(poses)
    placed, result = placed_cones(body, frames), np.empty(len(deltas))
    squared_scale = (FIRST_LOSS * p.loss_scale) ** 2
    places = np.ascontiguousarray(data)
    _robust_sums(places, placed, p.max_correspondence_distance, squared_scale, result)
    crowd = max(1.0, len(data) / p.effective_sample_size)
    result /= p.sigma_measurement**2 * crowd
    for residual in beside:
        nu = residual.measured - residual.predicted(frames)
        result += 0.5 * np.sum(nu**2 / residual.variance, axis=1)
    off, variance = limits.off_rest(limits.resting(joints), poses.rotations)
    result += 0.5 * np.sum(off**2 / variance, axis=1)
    for k in np.flatnonzero(_suspected(setup, frames, placed, poses)).tolist():
        rows = limits.limit_rows(body, poses[k], p, joints)
        rows = rows[rows["kind"] != REST_ROW]
        result[k] += 0.5 * float(np.sum(rows["innovation"] ** 2 / rows["variance"]))
    return result


def _suspected(setup: Setup, frames: PartFrames, placed: PlacedCones, poses: Pose) -> BoolArray:
    """Poses (K,) whose elbows may be folded too far, or whose forearms are at the torso."""
    arms, clearance = list(FOREARMS), setup.parameters.clearance
    straight = poses.rotations[:, arms][:, :, 2, 2].min(axis=1)
    folded = straight < -np.cos(limits.LEAST_ELBOW_ANGLE)
    if clearance <= 0.0:
        return np.asarray(folded)
    along = frames.rotations[:, arms][..., 2] * setup.body.skeleton.lengths[arms][:, None]
    places = frames.origins[:, arms, None] + _ALONG[:, None] * along[:, :, None]
    distance = np.empty(len(placed))
    _least_distances(places.reshape(len(placed), -1, 3), placed[:, 0].copy(), distance)
    return np.asarray(folded | (distance < clearance + _SLACK))


@compiled(inline="always")
def _distance(cone: Any, p: Any) -> float:
    px, py, pz = in_cone(cone, p[0], p[1], p[2])
    return closest_on_cone(cone, px, py, pz)[0]  # type: ignore[no-any-return]


@compiled()
def _robust_sums(points: Any, placed: Any, reach: float, squared_scale: float, out: Any) -> None:
    for k in range(placed.shape[0]):
        total = 0.0
        for i in range(points.shape[0]):
            nearest = reach
            for c in range(placed.shape[1]):
                nearest = min(nearest, abs(_distance(placed[k, c], points[i])))
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
