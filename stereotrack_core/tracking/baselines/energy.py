"""How badly many poses at once explain data: the tracker's own distances and limits, summed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numba
import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray
from stereotrack_core.body.manifold import displaced
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import PartFrames, Pose, t_pose
from stereotrack_core.body.skeleton import CLAVICLES, FOREARMS
from stereotrack_core.body.surface import cone_foot, cone_tables
from stereotrack_core.tracking.correction import Residual
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.residuals.limits import (
    limit_residuals,
    resting_limbs,
    shoulders_at_rest,
)

_ALONG = np.linspace(0.0, 1.0, 4)
"""Places along a forearm that may come close to the torso."""

_SLACK = 0.01
"""Metres by which an arm that is asked about its limits may be farther away than they say."""


class PoseEnergy:
    """Negative logarithm of the likelihood of poses, up to a constant.

    A datum at distance e from the surface counts g^2 e^2 / (2 (g^2 + e^2)) over its variance:
    the function whose derivative is the tracker's weight (g^2 / (g^2 + e^2))^2 times e. To this
    come half the squares of the limits' rows over their variances.

    Parameters
    ----------
    body : BodyModel
    parameters : TrackingParameters
    joints : tuple of int
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
        centre : Pose
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
            p.first_loss_scale**2,
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
        folded = straight < -np.cos(np.radians(self.parameters.least_elbow_angle))
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


@numba.njit(cache=True, nogil=True, inline="always")  # type: ignore[untyped-decorator]
def _distance(row: Any, p: Any) -> float:
    x, y, z = p[0] - row[9], p[1] - row[10], p[2] - row[11]
    px = row[0] * x + row[3] * y + row[6] * z
    py = row[1] * x + row[4] * y + row[7] * z
    pz = row[2] * x + row[5] * y + row[8] * z
    return cone_foot(row, px, py, pz)[0]  # type: ignore[no-any-return]


@numba.njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
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


@numba.njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def _least_distances(places: Any, rows: Any, out: Any) -> None:
    for k in range(rows.shape[0]):
        least = 1e9
        for i in range(places.shape[1]):
            least = min(least, _distance(rows[k], places[k, i]))
        out[k] = least
