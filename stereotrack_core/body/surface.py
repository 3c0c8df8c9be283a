"""The nearest place on the body's surface for a datum (docs/method.md 4.1).

The loops over data and cones are compiled: a frame asks for some thousand data against 15 cones
several times, and the search over arm poses for many more.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.model import BodyModel, Cones, PlacedCones
from stereotrack_core.body.pose import PartFrames
from stereotrack_core.body.skeleton import LIMB_OF_PART
from stereotrack_core.compiled import compiled

_NO_PENALTY = np.zeros((0, 0))


@dataclass(frozen=True, eq=False)
class ClosestPoints:
    """Nearest places on the surface for N data."""

    cone: IntArray
    """(N,). Index of the nearest cone; -1 where none takes the datum."""
    distance: FloatArray
    """(N,), metres. Signed: positive outside. Infinite where no cone takes the datum."""
    point: FloatArray
    """(N, 3), world."""
    direction: FloatArray
    """(N, 3), world. Unit vector along which the distance is measured: the side's normal, or from
    the point to the datum beyond an end."""


def cone_table(placed: PlacedCones) -> FloatArray:
    """One row (18,) for each cone with all that the compiled loops need."""
    table = np.empty((len(placed.cones), 18))
    table[:, :9] = placed.rotations.reshape(len(table), 9)
    table[:, 9:12], table[:, 12:] = placed.origins, placed.cones.sizes
    return table


def cone_tables(cones: Cones, frames: PartFrames) -> FloatArray:
    """Tables (..., C, 18) of cones in one pose or in a stack of poses; see :func:`cone_table`."""
    lead = frames.origins.shape[:-2]
    rotations = np.ascontiguousarray(frames.rotations).reshape(-1, *frames.rotations.shape[-3:])
    origins = np.ascontiguousarray(frames.origins).reshape(-1, *frames.origins.shape[-2:])
    tables = np.empty((len(origins), len(cones), 18))
    _place(cones.part, cones.rotations, cones.origins, cones.sizes, rotations, origins, tables)
    return tables.reshape(*lead, len(cones), 18)


@compiled()
def _place(
    part: Any, turns: Any, places: Any, sizes: Any, rotations: Any, origins: Any, tables: Any
) -> None:
    """Fill tables (K, C, 18) of cones that stand on their parts, in K poses."""
    for k in range(tables.shape[0]):
        for c in range(tables.shape[1]):
            R, row = rotations[k, part[c]], tables[k, c]
            for i in range(3):
                for j in range(3):
                    row[3 * i + j] = (
                        R[i, 0] * turns[c, 0, j]
                        + R[i, 1] * turns[c, 1, j]
                        + R[i, 2] * turns[c, 2, j]
                    )
                row[9 + i] = origins[k, part[c], i] + (
                    R[i, 0] * places[c, 0] + R[i, 1] * places[c, 1] + R[i, 2] * places[c, 2]
                )
            for i in range(sizes.shape[1]):  # assigned as a whole it takes seconds to compile
                row[12 + i] = sizes[c, i]


def nearest_on_surface(
    points: FloatArray, placed: PlacedCones, reach: float, penalty: FloatArray | None = None
) -> ClosestPoints:
    """Find the closest point to every datum on the nearest cone.

    Parameters
    ----------
    points : (N, 3) float64, world
    reach : float, metres
        Data farther than this from every cone belong to none.
    penalty : (N, C) float64, metres, optional
        What speaks against a cone besides its distance d, as its colour does: the nearest cone is
        that with the least sqrt(d^2 + penalty^2). The distances found are d all the same.
    """
    n = len(points)
    cone = np.full(n, -1, dtype=np.int64)
    distance = np.full(n, np.inf)
    point = np.full((n, 3), np.nan)
    direction = np.full((n, 3), np.nan)
    data = np.ascontiguousarray(points, dtype=np.float64)
    other = _NO_PENALTY if penalty is None else np.ascontiguousarray(penalty)
    _nearest(data, cone_table(placed), reach, other, cone, distance, point, direction)
    return ClosestPoints(cone, distance, point, direction)


def parts_of_cones(body: BodyModel, cone: IntArray) -> IntArray:
    """Part (N,) of each datum's cone; -1 stays -1."""
    return np.where(cone >= 0, body.cones.part[cone], -1)


def limbs_of_cones(body: BodyModel, cone: IntArray) -> IntArray:
    """Limb (N,) that each datum's cone counts for, ``len(LIMBS)`` for legs; -1 stays -1."""
    return np.where(cone >= 0, LIMB_OF_PART[body.cones.part[cone]], -1)


@compiled(inline="always")
def closest_on_cone(row: Any, px: float, py: float, pz: float) -> Any:
    """Signed distance, closest point (3) and direction (3) of a point, all in the cone's own frame.

    A datum beyond an end that is not round gets an infinite distance: inner ends take no data.
    """
    r1, r2, height, s = row[12], row[13], row[14], row[15]
    y = py / s
    rho = math.sqrt(px * px + y * y)
    if rho < 1e-9:
        cx, cy = 1.0, 0.0
    else:
        cx, cy = px / rho, y / rho
    dr = r2 - r1
    u = ((rho - r1) * dr + pz * height) / (dr * dr + height * height)
    if u > 1.0 and row[17] > 0.5:
        return _ball(r2, height, s, px, py, pz)
    if u < 0.0 and row[16] > 0.5:
        return _ball(r1, 0.0, s, px, py, pz)
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
def _is_farther(row: Any, px: float, py: float, pz: float, limit: float) -> Any:
    """Whether a round cone is surely farther than a limit: the cylinder around it is."""
    if row[15] != 1.0:
        return False
    past = max(-pz, pz - row[14], 0.0)
    room = limit + max(row[12], row[13])
    return px * px + py * py + past * past > room * room


@compiled()
def _nearest(
    points: Any,
    table: Any,
    reach: float,
    penalty: Any,
    cone: Any,
    distance: Any,
    point: Any,
    direction: Any,
) -> None:
    judged = penalty.shape[0] > 0
    for i in range(points.shape[0]):
        best = math.inf if judged else reach
        for c in range(table.shape[0]):
            row = table[c]
            x, y, z = points[i, 0] - row[9], points[i, 1] - row[10], points[i, 2] - row[11]
            px = row[0] * x + row[3] * y + row[6] * z
            py = row[1] * x + row[4] * y + row[7] * z
            pz = row[2] * x + row[5] * y + row[8] * z
            if _is_farther(row, px, py, pz, reach if judged else best):
                continue
            d, fx, fy, fz, nx, ny, nz = closest_on_cone(row, px, py, pz)
            off = abs(d)
            if judged:
                off = math.hypot(d, penalty[i, c]) if off < reach else math.inf
            if off < best:
                best = off
                cone[i] = c
                distance[i] = d
                for k in range(3):
                    a, b, e = row[3 * k], row[3 * k + 1], row[3 * k + 2]
                    point[i, k] = a * fx + b * fy + e * fz + row[9 + k]
                    direction[i, k] = a * nx + b * ny + e * nz
