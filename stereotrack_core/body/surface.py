"""The nearest place on the body's surface for a datum (docs/method.md 4.1).

Compiled: a frame asks for some thousand data against 15 cones several times, the arm search for
many more.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.model import BodyModel, PlacedCones
from stereotrack_core.body.skeleton import LIMB_OF_PART
from stereotrack_core.compiled import compiled

_NO_PENALTY = np.zeros((0, 0))


@dataclass(frozen=True, eq=False)
class ClosestPoints:
    """Nearest places on the surface for N data."""

    cone: IntArray  # (N,). Index of the nearest cone; -1 where none takes the datum.
    distance: FloatArray  # (N,), metres. Positive outside; infinite if no cone takes it
    point: FloatArray  # (N, 3), world
    direction: FloatArray  # (N, 3), world. Of the distance: normal, or towards the datum


def places_for(n: int) -> tuple[IntArray, FloatArray, FloatArray, FloatArray]:
    """Arrays of n :class:`ClosestPoints` that a loop is going to fill."""
    return np.empty(n, dtype=np.int64), np.empty(n), np.empty((n, 3)), np.empty((n, 3))


def nearest_on_surface(
    points: FloatArray, placed: PlacedCones, reach: float, penalty: FloatArray | None = None
) -> ClosestPoints:
    """Closest points to data (N, 3), world, on the nearest cone within `reach` metres.

    `penalty` (N, C), metres: what else speaks against a cone, as its colour does; the nearest cone
    is that with the least sqrt(d^2 + penalty^2). The distances returned are d all the same.
    """
    closest = places_for(len(points))
    data = np.ascontiguousarray(points, dtype=np.float64)
    other = _NO_PENALTY if penalty is None else np.ascontiguousarray(penalty)
    _nearest(data, np.ascontiguousarray(placed), float(reach), other, closest)
    return ClosestPoints(*closest)


def parts_of_cones(body: BodyModel, cone: IntArray) -> IntArray:
    """Part (N,) of each datum's cone; -1 stays -1."""
    return np.where(cone >= 0, body.cones["part"][cone], -1)


def limbs_of_cones(body: BodyModel, cone: IntArray) -> IntArray:
    """Limb (N,) that each datum's cone counts for, ``len(LIMBS)`` for legs; -1 stays -1."""
    return np.where(cone >= 0, LIMB_OF_PART[body.cones["part"][cone]], -1)


@compiled(inline="always")
def closest_on_cone(cone: Any, px: float, py: float, pz: float) -> Any:
    """Signed distance, closest point (3), direction (3), cone's frame; inf beyond flat ends."""
    r1, r2, height, s = cone.r1, cone.r2, cone.height, cone.flatness
    y = py / s
    rho = math.sqrt(px * px + y * y)
    if rho < 1e-9:
        cx, cy = 1.0, 0.0
    else:
        cx, cy = px / rho, y / rho
    dr = r2 - r1
    u = ((rho - r1) * dr + pz * height) / (dr * dr + height * height)
    if u > 1.0 and cone.round_end:
        return _ball(r2, height, s, px, py, pz)
    if u > 1.0 or u < 0.0:
        u = min(1.0, max(0.0, u))
        radius = r1 + u * dr
        fx, fy, fz = radius * cx, s * radius * cy, u * height
        dx, dy, dz = px - fx, py - fy, pz - fz
        d = math.sqrt(dx * dx + dy * dy + dz * dz)
        if rho < radius - 1e-9:
            return math.inf, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0
        if d > 1e-9:
            return d, fx, fy, fz, dx / d, dy / d, dz / d
    radius = r1 + u * dr
    fx, fy, fz = radius * cx, s * radius * cy, u * height
    nx, ny, nz = height * cx, height * cy / s, -dr
    norm = math.sqrt(nx * nx + ny * ny + nz * nz)
    nx, ny, nz = nx / norm, ny / norm, nz / norm
    d = (px - fx) * nx + (py - fy) * ny + (pz - fz) * nz
    return d, fx, fy, fz, nx, ny, nz


@compiled(inline="always")
def _ball(r: float, centre: float, s: float, px: float, py: float, pz: float) -> Any:
    y, z = py / s, pz - centre
    norm = math.sqrt(px * px + y * y + z * z)
    if norm < 1e-9:
        return math.inf, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0
    nx, ny, nz = px / norm, y / norm, z / norm
    fx, fy, fz = r * nx, s * r * ny, centre + r * nz
    dx, dy, dz = px - fx, py - fy, pz - fz
    d = math.sqrt(dx * dx + dy * dy + dz * dz)
    sign = 1.0 if norm >= r else -1.0
    if d < 1e-9:
        return 0.0, fx, fy, fz, nx, ny, nz
    return sign * d, fx, fy, fz, sign * dx / d, sign * dy / d, sign * dz / d


@compiled(inline="always")
def in_cone(cone: Any, x: float, y: float, z: float) -> Any:
    """A point (3), world, in the cone's own frame."""
    R, origin = cone.rotation, cone.origin
    x, y, z = x - origin[0], y - origin[1], z - origin[2]
    return (
        R[0, 0] * x + R[1, 0] * y + R[2, 0] * z,
        R[0, 1] * x + R[1, 1] * y + R[2, 1] * z,
        R[0, 2] * x + R[1, 2] * y + R[2, 2] * z,
    )


@compiled(inline="always")
def _is_farther(cone: Any, px: float, py: float, pz: float, limit: float) -> Any:
    """Whether a round cone is surely farther than a limit: the cylinder around it is."""
    if cone.flatness != 1.0:
        return False
    past = max(-pz, pz - cone.height, 0.0)
    room = limit + max(cone.r1, cone.r2)
    return px * px + py * py + past * past > room * room


@compiled()
def _nearest(points: Any, placed: Any, reach: float, penalty: Any, out_closest: Any) -> None:
    out_cone, out_distance, out_point, out_direction = out_closest
    judged = penalty.shape[0] > 0
    for i in range(points.shape[0]):
        best = math.inf if judged else reach
        out_cone[i], out_distance[i] = -1, math.inf
        for k in range(3):
            out_point[i, k] = out_direction[i, k] = math.nan
        for c in range(placed.shape[0]):
            cone = placed[c]
            px, py, pz = in_cone(cone, points[i, 0], points[i, 1], points[i, 2])
            if _is_farther(cone, px, py, pz, reach if judged else best):
                continue
            d, fx, fy, fz, nx, ny, nz = closest_on_cone(cone, px, py, pz)
            off = abs(d)
            if judged:
                off = math.hypot(d, penalty[i, c]) if off < reach else math.inf
            if off < best:
                best = off
                out_cone[i], out_distance[i] = c, d
                for k in range(3):
                    a, b, e = cone.rotation[k, 0], cone.rotation[k, 1], cone.rotation[k, 2]
                    out_point[i, k] = a * fx + b * fy + e * fz + cone.origin[k]
                    out_direction[i, k] = a * nx + b * ny + e * nz
