"""A pose, or a stack of poses; compiled, as a search asks for hundreds of poses in a frame."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
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
from stereotrack_core.compiled import compiled


@compiled()
def chain(
    turns: Any, position: Any, joints: Any, lengths: Any, out_rotations: Any, out_origins: Any
) -> None:
    """Chain the transforms of S poses from the torso outwards; carriers move joints along."""
    rotations, origins = out_rotations, out_origins
    for s in range(turns.shape[0]):
        _copy(turns[s, 0], rotations[s, 0])
        for i in range(3):
            origins[s, 0, i] = position[s, i]
        for part in range(1, turns.shape[1]):
            above, carrier = _PARENTS[part], _CARRIERS[part]
            x, y, z = joints[part, 0], joints[part, 1], joints[part, 2]
            if carrier >= 0:
                x += lengths[carrier] * (turns[s, carrier, 0, 2] - REST[carrier, 0, 2])
                y += lengths[carrier] * (turns[s, carrier, 1, 2] - REST[carrier, 1, 2])
                z += lengths[carrier] * (turns[s, carrier, 2, 2] - REST[carrier, 2, 2])
            for i in range(3):
                R = rotations[s, above, i]
                a, b, c = R[0], R[1], R[2]
                for j in range(3):
                    rotations[s, part, i, j] = (
                        a * turns[s, part, 0, j]
                        + b * turns[s, part, 1, j]
                        + c * turns[s, part, 2, j]
                    )
                origins[s, part, i] = origins[s, above, i] + (a * x + b * y + c * z)


@compiled()
def turn_towards(rotation: Any, direction: Any, result: Any) -> None:
    """Turn N rotations (N, 3, 3) the shortest way so that z points along directions (N, 3)."""
    turn = np.empty((3, 3))
    for n in range(rotation.shape[0]):
        R, d = rotation[n], direction[n]
        x = R[0, 0] * d[0] + R[1, 0] * d[1] + R[2, 0] * d[2]
        y = R[0, 1] * d[0] + R[1, 1] * d[1] + R[2, 1] * d[2]
        z = R[0, 2] * d[0] + R[1, 2] * d[1] + R[2, 2] * d[2]
        length = math.sqrt(x * x + y * y + z * z)
        x, y, z = x / length, y / length, z / length
        aside = x * x + y * y
        turn[:] = 0.0
        if z < 0.0 and aside < 1e-24:
            turn[0, 0], turn[1, 1], turn[2, 2] = 1.0, -1.0, -1.0
        else:
            # 1 / (1 + z), without cancellation where z is nearly -1
            c = (1.0 - z) / aside if z < 0.0 else 1.0 / (1.0 + z)
            turn[0, 0], turn[0, 1], turn[0, 2] = 1 - c * x * x, -c * x * y, x
            turn[1, 0], turn[1, 1], turn[1, 2] = -c * x * y, 1 - c * y * y, y
            turn[2, 0], turn[2, 1], turn[2, 2] = -x, -y, z
        for i in range(3):
            for j in range(3):
                result[n, i, j] = R[i, 0] * turn[0, j] + R[i, 1] * turn[1, j] + R[i, 2] * turn[2, j]


@compiled()
def displace(rotations: Any, joints: Any, delta: Any, result: Any) -> None:
    """Fill (S, P, 3, 3) with parts (P, 3, 3) turned by error states (S, 6 + 2 J) of joints (J,)."""
    turn = np.empty((3, 3))
    for s in range(delta.shape[0]):
        for part in range(rotations.shape[0]):
            _copy(rotations[part], result[s, part])
        _turn(delta[s, 3], delta[s, 4], delta[s, 5], turn)
        _multiplied(turn, rotations[0], result[s, 0])
        for k in range(joints.shape[0]):
            _turn(delta[s, 6 + 2 * k], delta[s, 7 + 2 * k], 0.0, turn)
            _multiplied(rotations[joints[k]], turn, result[s, joints[k]])


@compiled(inline="always")
def _turn(x: float, y: float, z: float, turn: Any) -> None:
    """Fill the rotation matrix of a rotation vector (Rodrigues)."""
    squared = x * x + y * y + z * z
    if squared < 1e-8:
        a, b = 1.0 - squared / 6.0, 0.5 - squared / 24.0
    else:
        angle = math.sqrt(squared)
        a, b = math.sin(angle) / angle, (1.0 - math.cos(angle)) / squared
    xx, yy, zz, xy, xz, yz = b * x * x, b * y * y, b * z * z, b * x * y, b * x * z, b * y * z
    turn[0, 0], turn[0, 1], turn[0, 2] = 1.0 - yy - zz, xy - a * z, xz + a * y
    turn[1, 0], turn[1, 1], turn[1, 2] = xy + a * z, 1.0 - xx - zz, yz - a * x
    turn[2, 0], turn[2, 1], turn[2, 2] = xz - a * y, yz + a * x, 1.0 - xx - yy


@compiled(inline="always")
def _copy(A: Any, result: Any) -> None:
    """An assignment of whole arrays does the same, and takes seconds to compile."""
    for i in range(3):
        for j in range(3):
            result[i, j] = A[i, j]


@compiled(inline="always")
def _multiplied(A: Any, B: Any, result: Any) -> None:
    for i in range(3):
        for j in range(3):
            result[i, j] = A[i, 0] * B[0, j] + A[i, 1] * B[1, j] + A[i, 2] * B[2, j]


_PARENTS = np.array(PARENTS, dtype=np.int64)
_CARRIERS = np.array(CARRIERS, dtype=np.int64)
HANGING = np.diag([1.0, -1.0, -1.0])  # rotation of a limb at zero angles: z is the torso's -z


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


REST: FloatArray = _resting()  # (P, 3, 3) parent_from_part at zero angles; limbs hang


@dataclass(frozen=True, eq=False)
class Pose:
    """Pose of the body; leading dimensions stack poses."""

    position: FloatArray  # (..., 3), world, metres. Hip midpoint.
    rotations: FloatArray  # (..., P, 3, 3). world_from_torso, then parent_from_part of all others
    # Frames of the parts, once :meth:`BodyModel.frames` has computed them. Neither compared,
    # copied, saved nor pickled.
    known_frames: ClassVar[tuple[Skeleton, PartFrames] | None] = None

    def __getstate__(self) -> dict[str, FloatArray]:
        return {"position": self.position, "rotations": self.rotations}

    @property
    def torso(self) -> FloatArray:
        """Rotation world_from_torso (..., 3, 3)."""
        return self.rotations[..., TORSO, :, :]

    def values(self) -> dict[str, Any]:
        """Its numbers, which come back from JSON bit by bit."""
        return {"position": self.position.tolist(), "rotations": self.rotations.tolist()}

    def __getitem__(self, index: int | slice | IntArray) -> Pose:
        """Pose, or poses, of a stack."""
        return Pose(self.position[index], self.rotations[index])

    def turned(self, other_from_world: FloatArray) -> Pose:
        """The same pose, or poses, in a world turned by a rotation (3, 3)."""
        rotations = self.rotations.copy()
        rotations[..., TORSO, :, :] = other_from_world @ self.torso
        return Pose(self.position @ other_from_world.T, rotations)


@dataclass(frozen=True, eq=False)
class PartFrames:
    """Where every part is: p_world = rotations p_part + origins."""

    rotations: FloatArray  # (..., P, 3, 3)
    origins: FloatArray  # (..., P, 3), world, metres. The parts' joints.

    def apply(self, part: IntArray, points: FloatArray) -> FloatArray:
        """World points (..., N, 3) of points (N, 3) in the frames of parts (N,)."""
        turned = np.einsum("...nij,nj->...ni", self.rotations[..., part, :, :], points)
        return np.asarray(turned + self.origins[..., part, :])

    def local(self, part: IntArray, points: FloatArray) -> FloatArray:
        """Places (N, 3) in the frames of parts (N,) of world points (N, 3), for one pose."""
        away = points - self.origins[part]
        return np.asarray(np.einsum("nij,ni->nj", self.rotations[part], away))


def part_frames(skeleton: Skeleton, pose: Pose) -> PartFrames:
    """Forward kinematics (section 2.5): chain the transforms from the torso outwards."""
    shape = pose.rotations.shape
    turns = np.ascontiguousarray(pose.rotations).reshape(-1, *shape[-3:])
    position = np.ascontiguousarray(pose.position)
    if position.shape[:-1] != shape[:-3]:
        position = np.ascontiguousarray(np.broadcast_to(position, (*shape[:-3], 3)))
    rotations, origins = np.empty_like(turns), np.empty(turns.shape[:-1])
    bones = skeleton.joints, skeleton.lengths
    chain(turns, position.reshape(-1, 3), *bones, rotations, origins)
    return PartFrames(rotations.reshape(shape), origins.reshape(shape[:-1]))


def hanging_pose(position: FloatArray, torso: FloatArray | None = None) -> Pose:
    """Arms hang, the head is upright; hip midpoint (3,), world; faces north without `torso`."""
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
    """The pose with the nearest rotation matrices, by SVD, without accumulated rounding."""
    u, _, vt = np.linalg.svd(pose.rotations)
    return Pose(pose.position, u @ vt)


def rotation_towards(rotation: FloatArray, direction: FloatArray) -> FloatArray:
    """Rotations (..., 3, 3) turned the shortest way so that z is along unit vectors (..., 3)."""
    lead = np.broadcast_shapes(rotation.shape[:-2], direction.shape[:-1])
    stack = np.ascontiguousarray(np.broadcast_to(rotation, (*lead, 3, 3))).reshape(-1, 3, 3)
    along = np.ascontiguousarray(np.broadcast_to(direction, (*lead, 3))).reshape(-1, 3)
    result = np.empty_like(stack)
    if len(stack):
        turn_towards(stack, along, result)
    return result.reshape(*lead, 3, 3)
