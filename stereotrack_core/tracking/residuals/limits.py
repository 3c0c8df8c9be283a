"""Limits of joints and collisions as soft rows of the correction (docs/method.md 4.8)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TypeAlias

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.manifold import Columns, point_jacobian
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import REST, PartFrames, Pose
from stereotrack_core.body.skeleton import (
    CLAVICLES,
    FOREARMS,
    HEAD,
    PARENTS,
    SHANKS,
    THIGHS,
    TORSO,
    UPPER_ARMS,
)
from stereotrack_core.body.surface import nearest_on_surface
from stereotrack_core.geometry.triangulation import nearest_on_segments
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.state import GIRDLE_REST

_PARENTS = np.array(PARENTS, dtype=np.int64)

_REST_SIGMA = {
    HEAD: np.radians(20.0),
    **dict.fromkeys(THIGHS, np.radians(45.0)),
    **dict.fromkeys(SHANKS, np.radians(60.0)),
}
"""Standard deviation of the limbs that no measure counts from straight; they only take data."""


_GIRDLE: IntArray = np.repeat(np.array(CLAVICLES, dtype=np.int64), 2)
_ACROSS_GIRDLE: FloatArray = np.array([REST[part][:, k % 2] for k, part in enumerate(_GIRDLE)])
"""The clavicles' x and y axes at rest (4, 3), and whose they are; x is vertical."""

LEAST_ELBOW_ANGLE = np.radians(30.0)
"""Between upper arm and forearm."""

_ELBOW_SIGMA = np.radians(3.0)
"""How firmly an elbow is kept from folding farther than its limit."""


@dataclass(frozen=True, eq=False)
class DirectionResidual:
    """Components of parts' directions across axes that are fixed to their parents."""

    part: IntArray
    parent: IntArray
    """`part` and `parent`: (m,)."""
    across: FloatArray
    """(m, 3). Unit vectors in the parents' frames."""
    measured: FloatArray
    variance: FloatArray
    """`measured` and `variance`: (m,)."""

    def jacobian(self, frames: PartFrames, columns: Columns) -> FloatArray:
        """Derivatives (m, n): only a part's own joint turns it against its parent."""
        J = np.zeros((len(self.part), columns.n))
        rows = np.flatnonzero(columns.first[self.part] >= 0)
        part, at = self.part[rows], columns.first[self.part[rows]]
        across = np.einsum("mij,mj->mi", frames.rotations[self.parent[rows]], self.across[rows])
        along = np.einsum("mi,mij->mj", across, frames.rotations[part])
        J[rows, at], J[rows, at + 1] = -along[:, 1], along[:, 0]
        return J

    def predicted(self, frames: PartFrames) -> FloatArray:
        """Components (S, m)."""
        across = np.einsum("smij,mj->smi", frames.rotations[:, self.parent], self.across)
        along = frames.rotations[..., 2][:, self.part]
        result: FloatArray = np.einsum("smi,smi->sm", across, along)
        return result


@dataclass(frozen=True, eq=False)
class ClearanceResidual:
    """Distances of points of parts from the torso, along fixed directions of the torso's frame."""

    part: IntArray
    """(m,)."""
    points: FloatArray
    """(m, 3). In the frames of the parts."""
    outward: FloatArray
    """(m, 3). In the torso's frame."""
    measured: FloatArray
    variance: FloatArray
    """`measured` and `variance`: (m,)."""

    def jacobian(self, frames: PartFrames, columns: Columns) -> FloatArray:
        """Derivatives (m, n): the torso's own movement changes nothing."""
        world = frames.apply(self.part, self.points)
        outward = self.outward @ frames.rotations[TORSO].T
        J = point_jacobian(world, outward, self.part, frames, columns)
        J[:, :6] = 0.0
        return J

    def predicted(self, frames: PartFrames) -> FloatArray:
        """Places along the outward directions (S, m)."""
        world = frames.apply(self.part, self.points) - frames.origins[:, TORSO, None]
        local = np.einsum("sji,smj->smi", frames.rotations[:, TORSO], world)
        result: FloatArray = np.einsum("smi,mi->sm", local, self.outward)
        return result


@dataclass(frozen=True, eq=False)
class ApartResidual:
    """Distances between places on two arms along fixed directions."""

    left: IntArray
    right: IntArray
    """`left` and `right`: (m,). Parts."""
    on_left: FloatArray
    on_right: FloatArray
    """`on_left` and `on_right`: (m, 3). Places in the parts' frames."""
    direction: FloatArray
    """(m, 3), world. Unit vectors from the right arm to the left one."""
    measured: FloatArray
    variance: FloatArray
    """`measured` and `variance`: (m,)."""

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


Limit: TypeAlias = DirectionResidual | ClearanceResidual | ApartResidual


def limit_residuals(
    body: BodyModel, pose: Pose, parameters: TrackingParameters, joints: tuple[int, ...]
) -> tuple[Limit, ...]:
    """Rows for the limits that a pose violates, and for limbs that should rest.

    Those of :func:`resting_limbs` come first, then those for the shoulders.
    """
    rows: list[Limit] = [*resting_limbs(joints)]
    if CLAVICLES[0] in joints:
        off, variance = shoulders_at_rest(pose.rotations)
        across, nothing = _ACROSS_GIRDLE, np.zeros(len(off))
        rows.append(DirectionResidual(_GIRDLE, _PARENTS[_GIRDLE], across, nothing, variance))
    rows += _folded_elbows(pose, LEAST_ELBOW_ANGLE)
    frames = body.frames(pose)
    rows += _collisions(body, frames, parameters.clearance)
    if parameters.arms_apart > 0.0:
        rows += arms_apart(body, frames, parameters.arms_apart)
    return tuple(rows)


@cache
def resting_limbs(joints: tuple[int, ...]) -> tuple[DirectionResidual, ...]:
    """Two rows for every limb that should rest, whatever the pose."""
    part = np.repeat([joint for joint in joints if joint in _REST_SIGMA], 2).astype(np.int64)
    if not len(part):
        return ()
    across = np.array([REST[joint][:, k % 2] for k, joint in enumerate(part)])
    variance = np.array([_REST_SIGMA[joint] ** 2 for joint in part.tolist()])
    return (DirectionResidual(part, _PARENTS[part], across, np.zeros(len(part)), variance),)


def shoulders_at_rest(rotations: FloatArray) -> tuple[FloatArray, FloatArray]:
    """How far clavicles (..., 4) are from their rest across two axes each, and with what variance.

    The farther shoulders are lifted, pushed forward or drawn back, the less they are held: the
    negative logarithm of a Cauchy density, by iterated weights. They rest most of the time, and
    where they do not they may be anywhere; but nobody lowers them far.

    Parameters
    ----------
    rotations : (..., P, 3, 3) float64
        Of a pose, or of stacked ones.
    """
    off = np.einsum("mi,...mi->...m", _ACROSS_GIRDLE, rotations[..., 2][..., _GIRDLE, :])
    lowered = off * _ACROSS_GIRDLE[:, 2] < 0.0
    return off, GIRDLE_REST**2 + np.where(lowered, 0.0, off) ** 2


def _folded_elbows(pose: Pose, least_angle: float) -> list[DirectionResidual]:
    """Ask elbows that are bent beyond their limit to come back to it."""
    rows = []
    for fore in FOREARMS:
        along = pose.rotations[fore, :, 2]
        bend = float(np.arccos(np.clip(along[2], -1.0, 1.0)))
        excess = bend - (np.pi - least_angle)
        if excess > 0.0:
            side = along[:2] / max(float(np.linalg.norm(along[:2])), 1e-9)
            further = np.append(np.cos(bend) * side, -np.sin(bend))[None]
            part, variance = np.full(1, fore, dtype=np.int64), np.full(1, _ELBOW_SIGMA**2)
            back = np.array([-excess])
            rows.append(DirectionResidual(part, _PARENTS[part], further, back, variance))
    return rows


_COLLISION_SIGMA = 0.03
"""Metres; how firmly an arm is held off the torso."""

_CHECKED = 4
"""Places along a forearm, from elbow to hand, whose distance from the torso is checked."""


def _collisions(body: BodyModel, frames: PartFrames, clearance: float) -> list[ClearanceResidual]:
    """Hold the axes of forearms and hands off the torso's large cone."""
    if clearance <= 0.0:
        return []
    part = np.repeat(np.array(FOREARMS, dtype=np.int64), _CHECKED)
    points = np.zeros((len(part), 3))
    points[:, 2] = np.tile(np.linspace(0.0, body.skeleton.lengths[FOREARMS[0]], _CHECKED), 2)
    local = (frames.apply(part, points) - frames.origins[TORSO]) @ frames.rotations[TORSO]
    closest = nearest_on_surface(local, body.torso, 0.5)
    close = np.flatnonzero((closest.cone == 0) & (closest.distance < clearance))
    if not len(close):
        return []
    outward = closest.direction[close]
    at_limit = np.einsum("mi,mi->m", outward, closest.point[close]) + clearance
    variance = np.full(len(close), _COLLISION_SIGMA**2)
    return [ClearanceResidual(part[close], points[close], outward, at_limit, variance)]


# Where arms cross, data of the arm in front are near the surface of the one behind as well and
# draw it into the first; nothing in the data speaks against that.
PAIRS = (
    (FOREARMS[0], FOREARMS[1]),
    (UPPER_ARMS[0], FOREARMS[1]),
    (FOREARMS[0], UPPER_ARMS[1]),
)
"""Parts of the left and of the right arm that may meet."""

ROOM = np.array([1.0, 2.0, 2.0])
"""Least distances of the pairs' axes, in those of the forearms."""

_APART_SIGMA = 0.02
"""Metres; arms give way."""

_MEETING = 1e-4
"""Metres; axes that are nearer have no direction in which to part."""


def arms_apart(body: BodyModel, frames: PartFrames, least: float) -> list[ApartResidual]:
    """One row for each pair of parts that are nearer than they can be.

    Parameters
    ----------
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
            variance=np.full(len(near), _APART_SIGMA**2),
        )
    ]


def _axes(body: BodyModel, frames: PartFrames, part: IntArray) -> FloatArray:
    """Vectors (m, 3) from joint to joint, world."""
    return body.skeleton.lengths[part, None] * frames.rotations[part, :, 2]
