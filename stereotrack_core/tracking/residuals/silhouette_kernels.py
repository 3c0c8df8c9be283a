"""Compiled loops: where views graze the cones, and which edge is near."""

from __future__ import annotations

import math
from typing import Any

import numba
import numpy as np

_BESIDE = 0.04
"""Metres beside an outline that no other part may cover."""

_SLOPE = 1.5
"""Pixels over which the slope of the distances is taken."""

_OUTWARDS = 0.3
"""Least cosine between the edge's and the outline's outward directions."""

_SHARED = 2.5
"""Pixels between an edge and an outline of the trunk, within which it is not an arm's alone."""

_INSIDE = 3.0
"""Pixels inside of an edge where its range is read."""


@numba.njit(cache=True, nogil=True, inline="always")  # type: ignore[untyped-decorator]
def _grazed(row: Any, ex: float, ey: float, ez: float, u: float, side: float) -> Any:
    """Place on a cone's surface, its own frame, that a camera at (ex, ey, ez), world, grazes.

    The flattened cone is round in stretched coordinates, and touching survives stretching; the
    taper and the perspective within a cone's width are neglected.
    """
    dx, dy, dz = ex - row[9], ey - row[10], ez - row[11]
    s = row[15]
    wx = row[0] * dx + row[3] * dy + row[6] * dz
    wy = (row[1] * dx + row[4] * dy + row[7] * dz) / s
    norm = max(math.sqrt(wx * wx + wy * wy), 1e-9)
    radius = row[12] + u * (row[13] - row[12])
    return -side * radius * wy / norm, side * s * radius * wx / norm, u * row[14]


@numba.njit(cache=True, nogil=True, inline="always")  # type: ignore[untyped-decorator]
def _seen(row: Any, place: Any, pinhole: Any, x: float, y: float, z: float) -> Any:
    """World (3), column, row and range of a place (x, y, z) in a cone's frame."""
    px = row[0] * x + row[1] * y + row[2] * z + row[9]
    py = row[3] * x + row[4] * y + row[5] * z + row[10]
    pz = row[6] * x + row[7] * y + row[8] * z + row[11]
    a = place[0, 0] * px + place[0, 1] * py + place[0, 2] * pz + place[0, 3]
    b = place[1, 0] * px + place[1, 1] * py + place[1, 2] * pz + place[1, 3]
    c = place[2, 0] * px + place[2, 1] * py + place[2, 2] * pz + place[2, 3]
    near = max(c, 1e-6)
    return px, py, pz, pinhole[0] * a / near + pinhole[1], pinhole[0] * b / near + pinhole[2], c


@numba.njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def _capsules(table: Any, place: Any, pinhole: Any, eye: Any, capsules: Any) -> None:
    """Fill the cones' images (C, 7): two ends with radii in pixels, and whether in front."""
    for c in range(table.shape[0]):
        row, front = table[c], 1.0
        for end in range(2):
            x, y, z = _grazed(row, eye[0], eye[1], eye[2], float(end), 1.0)
            _, _, _, u1, v1, z1 = _seen(row, place, pinhole, x, y, z)
            _, _, _, u2, v2, z2 = _seen(row, place, pinhole, -x, -y, z)
            if min(z1, z2) < 0.2:
                front = 0.0
            capsules[c, 3 * end] = 0.5 * (u1 + u2)
            capsules[c, 3 * end + 1] = 0.5 * (v1 + v2)
            capsules[c, 3 * end + 2] = 0.5 * math.hypot(u1 - u2, v1 - v2)
        capsules[c, 6] = front


@numba.njit(cache=True, nogil=True, inline="always")  # type: ignore[untyped-decorator]
def _covered(capsules: Any, own: int, u: float, v: float) -> Any:
    """Whether another cone's image covers a pixel."""
    for c in range(capsules.shape[0]):
        if c == own or capsules[c, 6] < 0.5:
            continue
        ax, ay, ra = capsules[c, 0], capsules[c, 1], capsules[c, 2]
        bx, by = capsules[c, 3] - ax, capsules[c, 4] - ay
        length = max(bx * bx + by * by, 1e-9)
        t = min(1.0, max(0.0, ((u - ax) * bx + (v - ay) * by) / length))
        r = ra + t * (capsules[c, 5] - ra)
        x, y = u - ax - t * bx, v - ay - t * by
        if x * x + y * y < r * r:
            return True
    return False


@numba.njit(cache=True, nogil=True, inline="always")  # type: ignore[untyped-decorator]
def _shared(capsules: Any, limb: Any, u: float, v: float) -> Any:
    """Whether the outline of the trunk, the head or a leg lies at an edge as well."""
    for c in range(capsules.shape[0]):
        if limb[c] or capsules[c, 6] < 0.5:
            continue
        ax, ay, ra = capsules[c, 0], capsules[c, 1], capsules[c, 2]
        bx, by = capsules[c, 3] - ax, capsules[c, 4] - ay
        length = max(bx * bx + by * by, 1e-9)
        t = ((u - ax) * bx + (v - ay) * by) / length
        if not 0.0 <= t <= 1.0:
            continue
        r = ra + t * (capsules[c, 5] - ra)
        if abs(math.hypot(u - ax - t * bx, v - ay - t * by) - r) < _SHARED:
            return True
    return False


@numba.njit(cache=True, nogil=True, inline="always")  # type: ignore[untyped-decorator]
def _at(image: Any, u: float, v: float) -> Any:
    i, j = int(v), int(u)
    a, b = v - i, u - j
    upper = (1.0 - b) * image[i, j] + b * image[i, j + 1]
    lower = (1.0 - b) * image[i + 1, j] + b * image[i + 1, j + 1]
    return (1.0 - a) * upper + a * lower


@numba.njit(cache=True, nogil=True, inline="always")  # type: ignore[untyped-decorator]
def _edge_near(edge: Any, range_z: Any, u: float, v: float, depth: float, reach: float) -> Any:
    """Distance from the edge nearest to a pixel and its outward direction (2), in pixels.

    The direction is zero where there is no clear edge, or where its range is another part's.
    """
    value = _at(edge, u, v)
    gu = _at(edge, u + _SLOPE, v) - _at(edge, u - _SLOPE, v)
    gv = _at(edge, u, v + _SLOPE) - _at(edge, u, v - _SLOPE)
    slope = math.hypot(gu, gv)
    if slope < 1.0:
        return value, 0.0, 0.0
    gu, gv = gu / slope, gv / slope
    column = round(u - (value + _INSIDE) * gu)
    line = round(v - (value + _INSIDE) * gv)
    inside = 0 <= column < edge.shape[1] and 0 <= line < edge.shape[0]
    if not inside or abs(range_z[line, column] - depth) > reach:
        return value, 0.0, 0.0
    return value, gu, gv


@numba.njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def _centre(place: Any) -> Any:
    """World place (3,) of the camera with camera_from_world `place`."""
    eye = np.empty(3)
    for k in range(3):
        eye[k] = -(
            place[0, k] * place[0, 3] + place[1, k] * place[1, 3] + place[2, k] * place[2, 3]
        )
    return eye


@numba.njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def measure_outline(
    table: Any,
    measured: Any,
    limb: Any,
    margin: Any,
    edge: Any,
    range_z: Any,
    pinhole: Any,
    place: Any,
    along: Any,
    depth_reach: float,
    foot: Any,
    direction: Any,
    distance: Any,
    cone: Any,
) -> int:
    """Fill the outlines of one view and return how many there are.

    Parameters
    ----------
    table : (C, 18) float64
        See :func:`cone_table`.
    measured : (C,) bool
        Cones whose outlines are wanted.
    limb : (C,) bool
        Cones of arms; edges at which the trunk ends as well say nothing about them.
    margin : (C, 2) float64, metres
        How far the outline lies outside of the surface along the cones' x and y.
    edge, range_z, pinhole, place
        See :class:`EdgeMap`.
    along : (A,) float64
        Places along a cone, 0 at its base.
    depth_reach : float, metres
        An edge whose range differs by more than this from the outline's belongs to another part.
    foot, direction : (2 C A, 3) float64
    distance : (2 C A,) float64, metres
        From the outline to the edge, positive outwards.
    cone : (2 C A,) int64
    """
    capsules = np.empty((table.shape[0], 7))
    eye = _centre(place)
    _capsules(table, place, pinhole, eye, capsules)
    height, width = edge.shape
    n = 0
    for c in range(table.shape[0]):
        if not measured[c] or capsules[c, 6] < 0.5:
            continue
        row, image = table[c], capsules[c]
        for a in range(along.shape[0]):
            t = along[a]
            middle_u = image[0] + t * (image[3] - image[0])
            middle_v = image[1] + t * (image[4] - image[1])
            for k in range(2):
                x, y, z = _grazed(row, eye[0], eye[1], eye[2], t, 1.0 - 2.0 * k)
                px, py, pz, column, line, depth = _seen(row, place, pinhole, x, y, z)
                u, v = column - pinhole[3], line - pinhole[4]
                if not (2.0 <= u <= width - 4.0 and 2.0 <= v <= height - 4.0):
                    continue
                du, dv = column - middle_u, line - middle_v
                norm = math.hypot(du, dv)
                if norm < 0.5:
                    continue
                du, dv = du / norm, dv / norm
                beside = _BESIDE * pinhole[0] / depth
                if _covered(capsules, c, column + beside * du, line + beside * dv):
                    continue
                value, gu, gv = _edge_near(edge, range_z, u, v, depth, depth_reach)
                if not gu * du + gv * dv > _OUTWARDS:
                    continue
                if limb[c] and _shared(capsules, limb, column - value * gu, line - value * gv):
                    continue
                w = (gu * (column - pinhole[1]) + gv * (line - pinhole[2])) / pinhole[0]
                scale = math.sqrt(1.0 + w * w)
                for j in range(3):
                    direction[n, j] = (
                        place[0, j] * gu + place[1, j] * gv - place[2, j] * w
                    ) / scale
                widened = (margin[c, 0] * x * x + margin[c, 1] * y * y) / (x * x + y * y)
                distance[n] = -value * depth / pinhole[0] / scale - widened
                foot[n, 0], foot[n, 1], foot[n, 2], cone[n] = px, py, pz, c
                n += 1
    return n
