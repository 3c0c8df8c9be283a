"""A pose, or a stack of poses: where the torso is and how every part is turned."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.pose_kernels import chain, localise, turn_towards
from stereotrack_core.body.skeleton import (
    CARRIERS,
    CLAVICLES,
    HEAD,
    LEFT_UPPER_ARM,
    PARENTS,
    PARTS,
    RIGHT_UPPER_ARM,
    TORSO,
    Skeleton,
)

_PARENTS = np.array(PARENTS, dtype=np.int64)
_CARRIERS = np.array(CARRIERS, dtype=np.int64)

HANGING = np.diag([1.0, -1.0, -1.0])
"""Rotation of an arm or leg at zero angles: its z axis is the torso's -z."""


def _resting() -> FloatArray:
    rest = np.tile(np.eye(3), (len(PARTS), 1, 1))
    for part, parent in enumerate(PARENTS):
        if parent == TORSO and part not in (HEAD, *CLAVICLES):
            rest[part] = HANGING
    # Angles alpha draw a shoulder back, angles beta lower it.
    rest[CLAVICLES[0]] = [[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]
    rest[CLAVICLES[1]] = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]
    rest.flags.writeable = False
    return rest


REST: FloatArray = _resting()
"""Rotations (P, 3, 3) parent_from_part at zero angles: arms and legs hang, shoulders rest."""


@dataclass(frozen=True, eq=False)
class Pose:
    """Pose of the body; leading dimensions stack poses.

    Attributes
    ----------
    position : (..., 3) float64, world, metres
        Hip midpoint.
    rotations : (..., P, 3, 3) float64
        ``world_from_torso`` for the torso, ``parent_from_part`` for all other parts, in the
        order of ``PARTS``.
    """

    position: FloatArray
    rotations: FloatArray

    @property
    def torso(self) -> FloatArray:
        """Rotation world_from_torso (..., 3, 3)."""
        return self.rotations[..., TORSO, :, :]

    def __getitem__(self, index: int | slice | IntArray) -> Pose:
        """Pose, or poses, of a stack."""
        return Pose(self.position[index], self.rotations[index])


@dataclass(frozen=True, eq=False)
class PartFrames:
    """Where every part is: p_world = rotations p_part + origins.

    Attributes
    ----------
    rotations : (..., P, 3, 3) float64
    origins : (..., P, 3) float64, world, metres
        The parts' joints.
    """

    rotations: FloatArray
    origins: FloatArray

    def apply(self, part: IntArray, points: FloatArray) -> FloatArray:
        """World points (..., N, 3) of points (N, 3) in the frames of parts (N,)."""
        turned = np.einsum("...nij,nj->...ni", self.rotations[..., part, :, :], points)
        result: FloatArray = turned + self.origins[..., part, :]
        return result

    def local(self, part: IntArray, points: FloatArray) -> FloatArray:
        """Places (N, 3) in the frames of parts (N,) of world points (N, 3), for one pose."""
        result = np.empty((len(points), 3))
        localise(points, part, self.rotations, self.origins, result)
        return result


def part_frames(skeleton: Skeleton, pose: Pose) -> PartFrames:
    """Forward kinematics (section 2.5): chain the transforms from the torso outwards."""
    shape = pose.rotations.shape
    turns = np.ascontiguousarray(pose.rotations).reshape(-1, *shape[-3:])
    position = np.ascontiguousarray(pose.position)
    if position.shape[:-1] != shape[:-3]:
        position = np.ascontiguousarray(np.broadcast_to(position, (*shape[:-3], 3)))
    rotations, origins = np.empty_like(turns), np.empty(turns.shape[:-1])
    tree = (skeleton.joints, skeleton.lengths, _PARENTS, _CARRIERS, REST)
    chain(turns, position.reshape(-1, 3), *tree, rotations, origins)
    return PartFrames(rotations.reshape(shape), origins.reshape(shape[:-1]))


def hanging_pose(position: FloatArray, torso: FloatArray | None = None) -> Pose:
    """All joint angles zero: arms hang, elbows are straight, the head is upright.

    Parameters
    ----------
    position : (3,) float64, world, metres
        Hip midpoint.
    torso : (3, 3) float64, optional
        world_from_torso; facing north when not given (the torso's axes are then the world's).
    """
    rotations = REST.copy()
    if torso is not None:
        rotations[TORSO] = torso
    return Pose(np.asarray(position, dtype=np.float64), rotations)


def t_pose(position: FloatArray, torso: FloatArray | None = None) -> Pose:
    """Both arms stretched out sideways; facing north unless `torso` says otherwise."""
    pose = hanging_pose(position, torso)
    rotations = pose.rotations.copy()
    rotations[RIGHT_UPPER_ARM] = rotation_towards(HANGING, np.array([1.0, 0.0, 0.0]))
    rotations[LEFT_UPPER_ARM] = rotation_towards(HANGING, np.array([-1.0, 0.0, 0.0]))
    return Pose(pose.position, rotations)


def orthonormal(pose: Pose) -> Pose:
    """Take away what rounding has added to rotations that are products of many.

    The nearest rotation matrices, by singular value decomposition.
    """
    u, _, vt = np.linalg.svd(pose.rotations)
    return Pose(pose.position, u @ vt)


def rotation_towards(rotation: FloatArray, direction: FloatArray) -> FloatArray:
    """Turn `rotation` by the smallest angle so that its z axis points along `direction`.

    Parameters
    ----------
    rotation : (..., 3, 3) float64
    direction : (..., 3) float64
        Unit vectors, in the frame that `rotation` leads to. Opposite to the present axis the
        turn is made about the rotation's own x axis.

    Returns
    -------
    (..., 3, 3) float64
    """
    lead = np.broadcast_shapes(rotation.shape[:-2], direction.shape[:-1])
    stack = np.ascontiguousarray(np.broadcast_to(rotation, (*lead, 3, 3))).reshape(-1, 3, 3)
    along = np.ascontiguousarray(np.broadcast_to(direction, (*lead, 3))).reshape(-1, 3)
    result = np.empty_like(stack)
    if len(stack):
        turn_towards(stack, along, result)
    return result.reshape(*lead, 3, 3)
