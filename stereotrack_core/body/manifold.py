"""The error state on the manifold of poses (docs/method.md 4.5), and how points move with it.

The torso is displaced by a translation and a left rotation vector, both in the world; a limb by
two tangents, rotations about the x and y axes of its own frame. There is no place where a degree
of freedom is lost.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.pose import PartFrames, Pose, displace
from stereotrack_core.body.skeleton import CARRIERS, PARENTS, PARTS
from stereotrack_core.compiled import compiled
from stereotrack_core.geometry.rotation import vector_from_rotation


def error_names(joints: tuple[int, ...]) -> tuple[str, ...]:
    """Names of the error state's numbers for these joints."""
    torso = [f"torso_{name}" for name in ("x", "y", "z", "rx", "ry", "rz")]
    return (*torso, *(f"{PARTS[j]}_{axis}" for j in joints for axis in ("tx", "ty")))


def displaced(pose: Pose, delta: FloatArray, joints: tuple[int, ...]) -> Pose:
    """Displace one pose by error states (..., 6 + 2 J), in metres and radians, of these joints.

    The poses are stacked as `delta` is. Raises ValueError where that is of other joints.
    """
    if delta.shape[-1] != 6 + 2 * len(joints):
        raise ValueError(f"{delta.shape[-1]} numbers do not displace {len(joints)} joints")
    lead, shape = delta.shape[:-1], pose.rotations.shape
    stack = np.ascontiguousarray(delta, dtype=np.float64).reshape(-1, delta.shape[-1])
    rotations = np.empty((len(stack), *shape))
    turned = np.array(joints, dtype=np.int64)
    displace(np.ascontiguousarray(pose.rotations), turned, stack, rotations)
    return Pose(pose.position + delta[..., :3], rotations.reshape(*lead, *shape))


def difference(to: Pose, origin: Pose, joints: tuple[int, ...]) -> FloatArray:
    """Error state (6 + 2 J,) that displaces `origin` to `to`.

    A turn of a limb about its own axis, which displacements never make alone, is left out.
    """
    torso = vector_from_rotation(to.torso @ np.swapaxes(origin.torso, -1, -2))
    parts = list(joints)
    turned = np.swapaxes(origin.rotations[parts], -1, -2) @ to.rotations[parts]
    tangents = tangents_to_axis(turned[..., :, 2])
    return np.concatenate([to.position - origin.position, torso, tangents.reshape(-1)])


def tangents_to_axis(axis: FloatArray) -> FloatArray:
    """Tangents (..., 2) whose rotation turns (0, 0, 1) to the unit vectors `axis` (..., 3).

    Half a turn, which many rotations give, is made about x.
    """
    sine = np.hypot(axis[..., 0], axis[..., 1])
    angle = np.arctan2(sine, axis[..., 2])
    aside = sine > 1e-12
    factor = np.where(aside, angle / np.where(aside, sine, 1.0), 1.0)
    half_turn = np.where(~aside & (axis[..., 2] < 0), np.pi, 0.0)
    return np.stack([half_turn - axis[..., 1] * factor, axis[..., 0] * factor], axis=-1)


_PARENTS = np.array(PARENTS, dtype=np.int64)
_CARRIERS = np.array(CARRIERS, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Columns:
    """Where each part's joint stands in the error state of dimension n = 6 + 2 J.

    `first` (P,) is the first of a part's two columns; -1 for parts whose joints are not in the
    state.
    """

    n: int
    first: IntArray


def columns_of(joints: tuple[int, ...]) -> Columns:
    """Columns of an error state with these joints."""
    first = np.full(len(PARTS), -1, dtype=np.int64)
    first[list(joints)] = 6 + 2 * np.arange(len(joints))
    return Columns(6 + 2 * len(joints), first)


def point_jacobian(
    points: FloatArray,
    directions: FloatArray,
    part: IntArray,
    frames: PartFrames,
    columns: Columns,
) -> FloatArray:
    """Derivatives (m, n) of n . p(x) for points that move rigidly with their parts, in one pose.

    Points and directions are (m, 3), world. The torso turns about its origin by a left rotation
    vector, a limb about the x and y axes of its own frame: a turn about an axis a through o moves n
    . p by a . ((p - o) x n). What carries a limb's joint moves the limb as it moves the joint.
    """
    J = np.zeros((len(points), columns.n))
    _fill(
        np.ascontiguousarray(points),
        np.ascontiguousarray(directions),
        part,
        np.ascontiguousarray(frames.rotations),
        np.ascontiguousarray(frames.origins),
        _PARENTS,
        _CARRIERS,
        columns.first,
        J,
    )
    return J


def points_along(
    points: FloatArray, directions: FloatArray, part: IntArray, frames: PartFrames
) -> FloatArray:
    """Places n . p(x) (S, m) in metres of points on fixed directions, for S stacked poses.

    Points (m, 3) are in the frames of their parts, directions (m, 3) in the world.
    """
    along = np.empty((len(frames.origins), len(part)))
    _project(
        np.ascontiguousarray(points),
        np.ascontiguousarray(directions),
        part,
        np.ascontiguousarray(frames.rotations),
        np.ascontiguousarray(frames.origins),
        along,
    )
    return along


@compiled()
def _project(
    points: Any, directions: Any, part: Any, rotations: Any, origins: Any, along: Any
) -> None:
    turned = np.empty(9)
    for i in range(points.shape[0]):
        p = part[i]
        for j in range(3):
            for k in range(3):
                turned[3 * j + k] = directions[i, j] * points[i, k]
        for s in range(rotations.shape[0]):
            total = 0.0
            for j in range(3):
                total += directions[i, j] * origins[s, p, j]
                for k in range(3):
                    total += turned[3 * j + k] * rotations[s, p, j, k]
            along[s, i] = total


@compiled()
def _fill(
    points: Any,
    directions: Any,
    part: Any,
    rotations: Any,
    origins: Any,
    parents: Any,
    carriers: Any,
    first: Any,
    J: Any,
) -> None:
    for i in range(points.shape[0]):
        n = directions[i]
        J[i, 0], J[i, 1], J[i, 2] = n[0], n[1], n[2]
        p = part[i]
        while p >= 0:
            tx, ty, tz = _moment(points[i], origins[p], n)
            if p == 0:
                J[i, 3], J[i, 4], J[i, 5] = tx, ty, tz
            elif first[p] >= 0:
                for axis in range(2):
                    J[i, first[p] + axis] = _along_axis(rotations[p], axis, tx, ty, tz)
            carrier = carriers[p]
            if carrier >= 0 and first[carrier] >= 0:
                tx, ty, tz = _moment(origins[p], origins[carrier], n)
                for axis in range(2):
                    J[i, first[carrier] + axis] = _along_axis(rotations[carrier], axis, tx, ty, tz)
            p = parents[p]


@compiled(inline="always")
def _moment(point: Any, about: Any, n: Any) -> Any:
    """(p - o) x n."""
    x, y, z = point[0] - about[0], point[1] - about[1], point[2] - about[2]
    return y * n[2] - z * n[1], z * n[0] - x * n[2], x * n[1] - y * n[0]


@compiled(inline="always")
def _along_axis(rotation: Any, axis: int, x: float, y: float, z: float) -> float:
    total: float = x * rotation[0, axis] + y * rotation[1, axis] + z * rotation[2, axis]
    return total
