"""Registration of every limb by itself, with the joints imposed afterwards, as a baseline."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.manifold import Columns, difference, displaced, point_jacobian
from stereotrack_core.body.model import placed_cones
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.body.skeleton import PARENTS, PARTS, TORSO
from stereotrack_core.body.surface import nearest_on_surface
from stereotrack_core.filtering.linearisation import Information, posterior
from stereotrack_core.geometry.rotation import rotation_from_vector, vector_from_rotation
from stereotrack_core.tracking.baselines.base import Baseline
from stereotrack_core.tracking.correction import gathered
from stereotrack_core.tracking.estimator import Measurements, Prediction
from stereotrack_core.tracking.residuals.surface import SurfaceResidual, Trust, residual_of_closest
from stereotrack_core.tracking.state import Belief

ROUNDS, ITERATIONS = 4, 5
"""Rounds of giving the data to limbs, registering and joining these; closest-point iterations of a
limb in each."""

_LEAST_DATA = 6
"""Data without which a limb is not registered: it has six degrees of freedom."""

_LOOSE = np.diag(np.repeat([1.0 / 0.05**2, 1.0 / np.radians(20.0) ** 2], 3))
"""Information that keeps a limb from sliding and spinning where its data do not say how: 50 mm
and 20 deg in one iteration."""

_JOINING = 3
"""Gauss-Newton steps of the projection on the articulated poses, which is not quite linear."""


@dataclass(frozen=True, eq=False)
class Registered:
    """A limb that was registered without regard to the others.

    Attributes
    ----------
    part : int
    rotation : (3, 3) float64
        world_from_part.
    origin : (3,) float64, world, metres
    information : (6, 6) float64
        Inverse covariance of translation and left rotation vector, both in the world.
    """

    part: int
    rotation: FloatArray
    origin: FloatArray
    information: FloatArray


class LimbIcp(Baseline):
    """Closest points limb by limb, joined by least squares (Demirdjian, Darrell 2002).

    DOI 10.1109/ICMI.2002.1167005. The data are given to the nearest limbs; each limb is moved
    rigidly to its own data and forgets its joints; then the articulated pose is looked for whose
    limbs are nearest to those, measured by the covariance of each registration. What no limb
    says anything about stays where the prediction has it, by the process noise.
    """

    def settle(self, measured: Measurements, predicted: Prediction) -> Belief:
        """Register and join, a few times with data given to the limbs anew."""
        P0_inverse: FloatArray = np.linalg.inv(predicted.P).astype(np.float64)
        at: Belief = predicted
        joints = self.setup.joints
        for turn in range(ROUNDS):
            given = measured.surface(at.pose, wide=turn == 0)
            limbs = [
                self.register(part, given.data[given.part == part], at.pose, len(measured.data))
                for part in range(len(PARTS))
                if np.count_nonzero(given.part == part) >= _LEAST_DATA
            ]
            for _ in range(_JOINING):
                found = joined(limbs, measured, at.pose)
                from_prior = difference(predicted.pose, at.pose, joints)
                dx, P = posterior(P0_inverse, from_prior, found)
                at = Belief(displaced(at.pose, np.clip(dx, -0.5, 0.5), joints), P)
        return at

    def register(self, part: int, data: FloatArray, pose: Pose, all_data: int) -> Registered:
        """Move one part of a pose rigidly to its data (N, 3), which are so many of all data."""
        frames = self.setup.body.frames(pose)
        frames = PartFrames(frames.rotations.copy(), frames.origins.copy())
        information = np.zeros((6, 6))
        for _ in range(ITERATIONS):
            surface = self._own_surface(part, data, all_data, frames)
            arm = surface.foot - frames.origins[part]
            J = np.concatenate([surface.direction, np.cross(arm, surface.direction)], axis=1)
            weighted = J.T / surface.variance
            information = weighted @ J
            step = scipy.linalg.solve(
                information + _LOOSE, weighted @ surface.distance, assume_a="pos"
            )
            frames.origins[part] += step[:3]
            frames.rotations[part] = rotation_from_vector(step[3:]) @ frames.rotations[part]
        return Registered(part, frames.rotations[part], frames.origins[part], information)

    def _own_surface(
        self, part: int, data: FloatArray, all_data: int, frames: PartFrames
    ) -> SurfaceResidual:
        p, body = self.setup.parameters, self.setup.body
        own = body.cones.part == part
        feet = nearest_on_surface(
            data, placed_cones(body, frames)[own], p.max_correspondence_distance
        )
        effective = p.effective_sample_size * len(data) / all_data
        trust = Trust(p.max_correspondence_distance, p.loss_scale, p.sigma_measurement, effective)
        return residual_of_closest(data, np.where(feet.cone >= 0, part, -1), feet, frames, trust)


def joined(limbs: list[Registered], measured: Measurements, pose: Pose) -> Information:
    """What registered limbs, other sensors and limits say about a pose, linearised there."""
    setup = measured.setup
    frames = setup.body.frames(pose)
    rows = (*measured.beside(pose), *measured.limits(pose))
    total = gathered(rows, setup.body, pose, setup.columns)
    for limb in limbs:
        shift = limb.origin - frames.origins[limb.part]
        turn = vector_from_rotation(limb.rotation @ frames.rotations[limb.part].T)
        J = rigid_jacobian(limb.part, frames, setup.columns)
        weighted = J.T @ limb.information
        total += Information(weighted @ J, weighted @ np.concatenate([shift, turn]))
    return total


def rigid_jacobian(part: int, frames: PartFrames, columns: Columns) -> FloatArray:
    """Derivatives (6, n) of a part's translation and left rotation vector by the error state.

    Parameters
    ----------
    part : int
    frames : PartFrames
        Of one pose.
    columns : Columns
    """
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
