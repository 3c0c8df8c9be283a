"""Two arms cannot be in the same place: soft rows that hold them apart.

Where arms cross, data of the arm in front are near the surface of the one behind as well and draw
it into the first; nothing in the data speaks against that.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.manifold import Columns, point_jacobian
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import PartFrames
from stereotrack_core.body.skeleton import FOREARMS, UPPER_ARMS
from stereotrack_core.geometry.segments import nearest_on_segments

PAIRS = (
    (FOREARMS[0], FOREARMS[1]),
    (UPPER_ARMS[0], FOREARMS[1]),
    (FOREARMS[0], UPPER_ARMS[1]),
)
"""Parts of the left and of the right arm that may meet."""

ROOM = np.array([1.0, 2.0, 2.0])
"""Least distances of the pairs' axes, in those of the forearms."""

_SIGMA = 0.02
"""Metres; arms give way."""

_MEETING = 1e-4
"""Metres; axes that are nearer have no direction in which to part."""


@dataclass(frozen=True, eq=False)
class ApartResidual:
    """Distances between places on two arms along fixed directions.

    Attributes
    ----------
    left, right : (m,) int64
        Parts.
    on_left, on_right : (m, 3) float64
        Places in the parts' frames.
    direction : (m, 3) float64, world
        Unit vectors from the right arm to the left one.
    measured, variance : (m,) float64
    """

    left: IntArray
    right: IntArray
    on_left: FloatArray
    on_right: FloatArray
    direction: FloatArray
    measured: FloatArray
    variance: FloatArray

    def jacobian(self, frames: PartFrames, columns: Columns) -> FloatArray:
        """Derivatives (m, n)."""
        left, right = frames.apply(self.left, self.on_left), frames.apply(self.right, self.on_right)
        of_left = point_jacobian(left, self.direction, self.left, frames, columns)
        return of_left - point_jacobian(right, self.direction, self.right, frames, columns)

    def predicted(self, frames: PartFrames) -> FloatArray:
        """Distances (S, m) for stacked poses."""
        left, right = frames.apply(self.left, self.on_left), frames.apply(self.right, self.on_right)
        result: FloatArray = np.einsum("smi,mi->sm", left - right, self.direction)
        return result


def arms_apart(body: BodyModel, frames: PartFrames, least: float) -> list[ApartResidual]:
    """One row for each pair of parts that are nearer than they can be.

    Parameters
    ----------
    body : BodyModel
    frames : PartFrames
        Of one pose.
    least : float, metres
        Between the axes of the forearms.
    """
    left, right = np.array(PAIRS, dtype=np.int64).T
    a, along_a = frames.origins[left], _axes(body, frames, left)
    c, along_c = frames.origins[right], _axes(body, frames, right)
    s, t = nearest_on_segments(a, a + along_a, c, c + along_c)
    apart = a + s[:, None] * along_a - c - t[:, None] * along_c
    distance = np.linalg.norm(apart, axis=1)
    near = np.flatnonzero((distance < least * ROOM) & (distance > _MEETING))
    if not len(near):
        return []
    lengths, up = body.skeleton.lengths, np.array([0.0, 0.0, 1.0])
    return [
        ApartResidual(
            left=left[near],
            right=right[near],
            on_left=(s * lengths[left])[near, None] * up,
            on_right=(t * lengths[right])[near, None] * up,
            direction=apart[near] / distance[near, None],
            measured=least * ROOM[near],
            variance=np.full(len(near), _SIGMA**2),
        )
    ]


def _axes(body: BodyModel, frames: PartFrames, part: IntArray) -> FloatArray:
    """Vectors (m, 3) from joint to joint, world."""
    result: FloatArray = body.skeleton.lengths[part, None] * frames.rotations[part, :, 2]
    return result
