"""The error state on the manifold of poses (docs/method.md 4.5), and how points move with it.

The torso is displaced by a translation and a left rotation vector, both in the world; a limb by two
tangents, rotations about x and y of its own frame. No degree of freedom is lost anywhere.
"""

import math
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.pose import PartFrames, Pose, displace
from stereotrack_core.body.skeleton import CARRIERS, PARENTS, PARTS
from stereotrack_core.compiled import compiled


def error_names(joints: tuple[int, ...]) -> tuple[str, ...]:
    """Names of the error state's numbers for these joints."""
    torso = [f"torso_{name}" for name in ("x", "y", "z", "rx", "ry", "rz")]
    return (*torso, *(f"{PARTS[j]}_{axis}" for j in joints for axis in ("tx", "ty")))


def displaced(pose: Pose, delta: FloatArray, joints: tuple[int, ...]) -> Pose:
    """Displace by error states (..., 6 + 2 J), metres, radians; ValueError for other joints."""
    if delta.shape[-1] != 6 + 2 * len(joints):
        raise ValueError(f"{delta.shape[-1]} numbers do not displace {len(joints)} joints")
    lead, shape = delta.shape[:-1], pose.rotations.shape
    stack = np.ascontiguousarray(delta, dtype=np.float64).reshape(-1, delta.shape[-1])
    rotations = np.empty((len(stack), *shape))
    turned = np.array(joints, dtype=np.int64)
    displace(np.ascontiguousarray(pose.rotations), turned, stack, rotations)
    return Pose(pose.position + delta[..., :3], rotations.reshape(*lead, *shape))


def difference(to: Pose, origin: Pose, joints: tuple[int, ...]) -> FloatArray:
    """Error state (6 + 2 J,) from `origin` to `to`, without turns of limbs about their own axes."""
    delta = np.zeros(6 + 2 * len(joints))
    if to is not origin:
        delta[:3] = to.position - origin.position
        _difference(to.rotations, origin.rotations, np.array(joints, dtype=np.int64), delta)
    return delta


@compiled()
def _difference(to: Any, origin: Any, joints: Any, out_delta: Any) -> None:
    """Fill the torso's rotation vector and the joints' tangents."""
    turn = np.empty((3, 3))
    for i in range(3):
        for j in range(3):
            turn[i, j] = to[0, i, 0] * origin[0, j, 0] + to[0, i, 1] * origin[0, j, 1]
            turn[i, j] += to[0, i, 2] * origin[0, j, 2]
    # The column of the quaternion's outer product with the largest diagonal: exact for any angle.
    trace = turn[0, 0] + turn[1, 1] + turn[2, 2]
    k = 0
    for i in range(1, 3):
        k = i if turn[i, i] > turn[k, k] else k
    a, b = (k + 1) % 3, (k + 2) % 3
    q = np.empty(3)
    if trace > turn[k, k]:
        w = 1.0 + trace
        for i in range(3):
            q[i] = turn[(i + 2) % 3, (i + 1) % 3] - turn[(i + 1) % 3, (i + 2) % 3]
    else:
        w = turn[b, a] - turn[a, b]
        q[k] = 1.0 + 2.0 * turn[k, k] - trace
        q[a], q[b] = turn[a, k] + turn[k, a], turn[b, k] + turn[k, b]
    sine, sign = math.sqrt(q[0] ** 2 + q[1] ** 2 + q[2] ** 2), -1.0 if w < 0.0 else 1.0
    factor = 2.0 * math.atan2(sine, abs(w)) / sine if sine > 0.0 else 0.0
    for i in range(3):
        out_delta[3 + i] = sign * factor * q[i]
    for k in range(joints.shape[0]):
        R, z = origin[joints[k]], to[joints[k]]
        x = R[0, 0] * z[0, 2] + R[1, 0] * z[1, 2] + R[2, 0] * z[2, 2]
        y = R[0, 1] * z[0, 2] + R[1, 1] * z[1, 2] + R[2, 1] * z[2, 2]
        cosine = R[0, 2] * z[0, 2] + R[1, 2] * z[1, 2] + R[2, 2] * z[2, 2]
        sine = math.hypot(x, y)
        if sine > 1e-12:
            factor = math.atan2(sine, cosine) / sine
            out_delta[6 + 2 * k], out_delta[7 + 2 * k] = -y * factor, x * factor
        elif cosine < 0.0:  # half a turn, which many rotations give, is made about x
            out_delta[6 + 2 * k] = math.pi


_PARENTS = np.array(PARENTS, dtype=np.int64)
_CARRIERS = np.array(CARRIERS, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Columns:
    """Columns of an error state of dimension n = 6 + 2 J: `first` (P,) of each part's, or -1."""

    n: int
    first: IntArray


def columns_of(joints: tuple[int, ...]) -> Columns:
    """Columns of an error state with these joints."""
    first = np.full(len(PARTS), -1, dtype=np.int64)
    first[list(joints)] = 6 + 2 * np.arange(len(joints))
    return Columns(6 + 2 * len(joints), first)


_WHICH = [(name, "i8") for name in ("kind", "part", "until", "other")]
_WHERE = [(name, "f8", (3,)) for name in ("point", "other_point", "direction")]
# One number that depends on the pose, linearised: n . (p - q), with its innovation z - z_hat. The
# `point` p moves rigidly with its `part`, q with the part `other` unless that is -1; both and the
# `direction` n are in the world. Joints count from the part up to, but without, the part `until`
# (-1: the world). `kind` is an index in KINDS.
ROW = np.dtype([*_WHICH, *_WHERE, ("innovation", "f8"), ("variance", "f8")], align=True)
Rows: TypeAlias = np.ndarray[Any, np.dtype[np.void]]  # records ``ROW`` (m,)
KINDS = ("surface", "outline", "rest", "elbow", "torso", "arms", "detection", "pixel")
SURFACE, OUTLINE, REST_ROW, ELBOW, TORSO_ROW, ARMS, DETECTION, PIXEL = range(len(KINDS))


def rows_of(
    kind: int, part: IntArray, point: FloatArray, direction: FloatArray, off: tuple[Any, Any]
) -> Rows:
    """Rows (m,) of points (m, 3) of parts on directions (m, 3), world; `off`: nu and R."""
    rows = np.empty(len(point), dtype=ROW)
    rows["kind"], rows["part"], rows["until"], rows["other"] = kind, part, -1, -1
    rows["point"], rows["direction"] = point, direction
    rows["innovation"], rows["variance"] = off
    return rows


def jacobian(rows: Rows, frames: PartFrames, columns: Columns) -> FloatArray:
    """Derivatives (m, n) of the rows' numbers by the error state, at one pose.

    A turn about an axis a through o moves n . p by a . ((p - o) x n). What carries a limb's joint
    moves the limb as it moves the joint.
    """
    J = np.zeros((len(rows), columns.n))
    _fill(rows, frames.rotations, frames.origins, columns.first, J)
    return J


def point_jacobian(
    points: FloatArray, directions: FloatArray, part: IntArray, frames: PartFrames, columns: Columns
) -> FloatArray:
    """Derivatives (m, n) of n . p(x) for points that move rigidly with their parts, in one pose."""
    return jacobian(rows_of(SURFACE, part, points, directions, (0.0, 1.0)), frames, columns)


@compiled()
def gather(rows: Any, rotations: Any, origins: Any, first: Any, out_A: Any, out_b: Any) -> None:
    """Add H' R^-1 H (n, n) and H' R^-1 nu (n,) of rows, each of 6 to 18 numbers; H is not made."""
    h, at = np.zeros(out_b.shape[0]), np.empty(out_b.shape[0], dtype=np.int64)
    for i in range(rows.shape[0]):
        _derive(rows[i], rotations, origins, first, h)
        count = 0
        for j in range(h.shape[0]):
            if h[j] != 0.0:
                at[count] = j
                count += 1
        for j in range(count):
            weighted = h[at[j]] / rows[i].variance
            out_b[at[j]] += weighted * rows[i].innovation
            for k in range(j + 1):
                out_A[at[j], at[k]] += weighted * h[at[k]]
        for j in range(count):
            h[at[j]] = 0.0
    for j in range(h.shape[0]):
        for k in range(j):
            out_A[k, j] = out_A[j, k]


@compiled()
def _fill(rows: Any, rotations: Any, origins: Any, first: Any, out_J: Any) -> None:
    for i in range(rows.shape[0]):
        _derive(rows[i], rotations, origins, first, out_J[i])


@compiled()
def _derive(row: Any, rotations: Any, origins: Any, first: Any, out_h: Any) -> None:
    """Add the derivatives (n,) of one row's number to zeros."""
    for end in range(2):
        point, n, sign = row.point, row.direction, 1.0
        p = row.part
        if end:
            if row.other < 0:
                return
            point, p, sign = row.other_point, row.other, -1.0
        while p != row.until:
            tx, ty, tz = _moment(point, origins[p], n)
            if p == 0:
                out_h[0] += sign * n[0]
                out_h[1] += sign * n[1]
                out_h[2] += sign * n[2]
                out_h[3] += sign * tx
                out_h[4] += sign * ty
                out_h[5] += sign * tz
            elif first[p] >= 0:
                for axis in range(2):
                    out_h[first[p] + axis] += sign * _along_axis(rotations[p], axis, tx, ty, tz)
            carrier = _CARRIERS[p]
            if carrier >= 0 and first[carrier] >= 0:
                tx, ty, tz = _moment(origins[p], origins[carrier], n)
                for axis in range(2):
                    moved = _along_axis(rotations[carrier], axis, tx, ty, tz)
                    out_h[first[carrier] + axis] += sign * moved
            p = _PARENTS[p]


@compiled(inline="always")
def _moment(point: Any, about: Any, n: Any) -> Any:
    """(p - o) x n."""
    x, y, z = point[0] - about[0], point[1] - about[1], point[2] - about[2]
    return y * n[2] - z * n[1], z * n[0] - x * n[2], x * n[1] - y * n[0]


@compiled(inline="always")
def _along_axis(rotation: Any, axis: int, x: float, y: float, z: float) -> float:
    total: float = x * rotation[0, axis] + y * rotation[1, axis] + z * rotation[2, axis]
    return total
