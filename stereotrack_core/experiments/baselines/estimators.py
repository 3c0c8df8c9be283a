"""Other estimators that the tracker is measured against, by the parameter `estimator`.

Each finds a pose and its covariance by a frame's measurements and its prediction, as
:data:`iekf.Baseline` says; all else is the tracker's. There is neither the search for arms nor a
prior that is widened where the data ask for it.
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.manifold import Columns, difference, displaced, point_jacobian
from stereotrack_core.body.model import placed_cones
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.body.skeleton import PARENTS, PARTS, TORSO
from stereotrack_core.body.surface import nearest_on_surface
from stereotrack_core.filtering.linearisation import Information, posterior
from stereotrack_core.geometry.rotation import rotation_from_vector, vector_from_rotation
from stereotrack_core.tracking.correction import gathered
from stereotrack_core.tracking.measurements import Measurements
from stereotrack_core.tracking.residuals.surface import Trust, residual_of_closest
from stereotrack_core.tracking.state import Belief, Setup, State

RANDOM = 3  # purpose for which baselines draw random numbers


def extended_kalman(measured: Measurements, predicted: Belief, _: State) -> tuple[Belief, None]:
    """One linearisation at the prediction, one correction (Kalman, DOI 10.1115/1.3662552).

    In the information form: P = (P0^-1 + H' R^-1 H)^-1 and dx = P H' R^-1 nu, the same by the
    matrix inversion lemma; there are many more data than states.
    """
    surface = measured.surface(predicted.pose, wide=True)
    return measured.corrected(predicted, predicted, surface), None


STEPS, _DRAWN = 80, 300  # steps of the descent in a frame, and data drawn for each
_FIRST_GAIN, _LARGEST_GAIN = 0.2, 0.7  # gains, in units of one over the curvature
_META = 0.1  # gain by which gains are adapted
_MEMORY = 0.9  # how long the gains' own gradient remembers
_LEAST_CURVATURE = 0.1  # of the mean distance, of a number that no datum speaks about
_LONGEST = 0.1  # metres and radians by which one step may move a number


def scalar_distance(measured: Measurements, predicted: Belief, _: State) -> tuple[Belief, None]:
    """Stochastic meta descent on the sum of distances (Kehl, Bray, Van Gool 2005).

    DOI 10.1109/CVPR.2005.165; the descent is Schraudolph's, DOI 10.1049/cp:19991170. Every step
    draws other data and descends along the gradient g of their robust squared distances, each
    number with a gain of its own, which grows while steps agree:

    gain <- gain max(1/2, 1 - mu g v), dx = -gain g, v <- lambda v - gain (g + lambda H v)

    with the curvature H of the distances, both per datum. Gains are held below the stable ones of
    single numbers. There is no prior: each frame starts at the prediction
    and ends where the sum is least. The covariance that is stated, and nothing else, joins that
    curvature with the process noise.
    """
    setup, rng, pose = measured.setup, measured.random(RANDOM), predicted.pose
    share = 1.0 / setup.parameters.effective_sample_size
    slope = _slope_at(measured, pose, wide=True)
    gain = _FIRST_GAIN / (share * np.diagonal(slope.A) + _LEAST_CURVATURE)
    v = np.zeros(len(predicted.P))
    for i in range(STEPS):
        drawn = measured.data[rng.integers(0, len(measured.data), _DRAWN)]
        slope = _slope_at(replace(measured, data=drawn), pose, wide=2 * i < STEPS)
        g, H = -share * slope.b, share * slope.A
        longest = _LARGEST_GAIN / (np.diagonal(H) + _LEAST_CURVATURE)
        gain = np.minimum(gain * np.maximum(0.5, 1.0 - _META * g * v), longest)
        pose = displaced(pose, np.clip(-gain * g, -_LONGEST, _LONGEST), setup.joints)
        v = np.clip(_MEMORY * v - gain * (g + _MEMORY * (H @ v)), -1.0, 1.0)
    found = _slope_at(measured, pose, wide=False)
    P0_inverse: FloatArray = np.linalg.inv(predicted.P).astype(np.float64)
    return Belief(pose, posterior(P0_inverse, np.zeros(len(v)), found)[1]), None


def _slope_at(measured: Measurements, pose: Pose, *, wide: bool) -> Information:
    """Curvature and negative gradient of the sum at a pose; sensors and limits take part."""
    frames, columns = measured.setup.body.frames(pose), measured.setup.columns
    seen = (measured.surface(pose, wide=wide), *measured.beside(pose))
    rows = (*(each.rows(frames) for each in seen), measured.limits(pose))
    return gathered(rows, frames, columns)


ROUNDS, ITERATIONS = 4, 5  # rounds of giving data to limbs; closest-point iterations in each
_LEAST_DATA = 6  # data without which a limb is not registered: it has six degrees of freedom
_LOOSE = np.diag(np.repeat([1.0 / 0.05**2, 1.0 / np.radians(20.0) ** 2], 3))
"""Information that keeps a limb from sliding and spinning where its data do not say how: 50 mm
and 20 deg in one iteration."""

_JOINING = 3  # Gauss-Newton steps of joining limbs, which is not quite linear


@dataclass(frozen=True, eq=False)
class Registered:
    """A limb that was registered without regard to the others."""

    part: int
    rotation: FloatArray  # (3, 3). world_from_part.
    origin: FloatArray  # (3,), world, metres
    information: FloatArray  # (6, 6), world; of translation and left rotation vector


def limb_icp(measured: Measurements, predicted: Belief, _: State) -> tuple[Belief, None]:
    """Closest points limb by limb, joined by least squares (Demirdjian, Darrell 2002).

    DOI 10.1109/ICMI.2002.1167005. The data are given to the nearest limbs; each limb is moved
    rigidly to its own data and forgets its joints; then the articulated pose is looked for whose
    limbs are nearest to those, measured by the covariance of each registration. What no limb
    says anything about stays where the prediction has it, by the process noise.
    """
    P0_inverse: FloatArray = np.linalg.inv(predicted.P).astype(np.float64)
    at, setup = predicted, measured.setup
    for turn in range(ROUNDS):
        given = measured.surface(at.pose, wide=turn == 0)
        own = {part: given.data[given.part == part] for part in range(len(PARTS))}
        enough = {part: data for part, data in own.items() if len(data) >= _LEAST_DATA}
        limbs = [_registered(k, d, at.pose, setup, len(measured.data)) for k, d in enough.items()]
        for _turn in range(_JOINING):
            from_prior = difference(predicted.pose, at.pose, setup.joints)
            dx, P = posterior(P0_inverse, from_prior, _joined(limbs, measured, at.pose))
            at = Belief(displaced(at.pose, np.clip(dx, -0.5, 0.5), setup.joints), P)
    return at, None


def _registered(part: int, data: FloatArray, pose: Pose, setup: Setup, all_data: int) -> Registered:
    """Move one part of a pose rigidly to its data (N, 3), which are so many of all data."""
    p, body, own = setup.parameters, setup.body, setup.body.cones["part"] == part
    reach, effective = p.max_correspondence_distance, p.effective_sample_size * len(data) / all_data
    trust = Trust(reach, p.loss_scale, p.sigma_measurement, effective)
    frames = body.frames(pose)
    frames = PartFrames(frames.rotations.copy(), frames.origins.copy())
    for _ in range(ITERATIONS):
        closest = nearest_on_surface(data, placed_cones(body, frames)[own], reach)
        part_of_data = np.where(closest.cone >= 0, part, -1)
        surface = residual_of_closest(data, part_of_data, closest, frames, trust)
        arm = surface.point - frames.origins[part]
        J = np.concatenate([surface.direction, np.cross(arm, surface.direction)], axis=1)
        weighted = J.T / surface.variance
        information = weighted @ J
        step = scipy.linalg.solve(information + _LOOSE, weighted @ surface.distance, assume_a="pos")
        frames.origins[part] += step[:3]
        frames.rotations[part] = rotation_from_vector(step[3:]) @ frames.rotations[part]
    return Registered(part, frames.rotations[part], frames.origins[part], information)


def _joined(limbs: list[Registered], measured: Measurements, pose: Pose) -> Information:
    """What registered limbs, other sensors and limits say about a pose, linearised there."""
    setup = measured.setup
    frames = setup.body.frames(pose)
    rows = (*(each.rows(frames) for each in measured.beside(pose)), measured.limits(pose))
    total = gathered(rows, frames, setup.columns)
    for limb in limbs:
        shift = limb.origin - frames.origins[limb.part]
        turn = vector_from_rotation(limb.rotation @ frames.rotations[limb.part].T)
        J = _rigid_jacobian(limb.part, frames, setup.columns)
        weighted = J.T @ limb.information
        total += Information(weighted @ J, weighted @ np.concatenate([shift, turn]))
    return total


def _rigid_jacobian(part: int, frames: PartFrames, columns: Columns) -> FloatArray:
    """Derivatives (6, n) of a part's translation and left rotation vector by the error state."""
    origin = np.repeat(frames.origins[part][None], 3, axis=0)
    J = np.zeros((6, columns.n))
    J[:3] = point_jacobian(origin, np.eye(3), np.full(3, part), frames, columns)
    while part != TORSO:
        at = columns.first[part]
        if at >= 0:
            J[3:, at : at + 2] = frames.rotations[part][:, :2]
        part = PARENTS[part]
    J[3:, 3:6] = np.eye(3)
    return J
