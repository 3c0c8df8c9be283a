"""Compiled loops of the search: thousands of arms against hundreds of data in every frame."""

from __future__ import annotations

import math
from typing import Any

import numba

_DEEP = -0.03
"""Metres from the torso's surface, negative inside, from which an arm's axis is too deep: bodies
give way where arms lie on them."""

_FOLDED, _FOLDING = math.radians(140.0), math.radians(15.0)


@numba.njit(cache=True, nogil=True, error_model="numpy")  # type: ignore[untyped-decorator]
def arm_distances(points: Any, nodes: Any, radii: Any, result: Any) -> None:
    """Fill unsigned distances (K, N) of points (3, N) from the surfaces of arms (K, 4, 3)."""
    result[:] = math.inf
    x, y, z = points[0], points[1], points[2]
    for k in range(nodes.shape[0]):
        near = result[k]
        for s in range(3):
            ax, ay, az = nodes[k, s, 0], nodes[k, s, 1], nodes[k, s, 2]
            bx, by = nodes[k, s + 1, 0] - ax, nodes[k, s + 1, 1] - ay
            bz = nodes[k, s + 1, 2] - az
            share = 1.0 / (bx * bx + by * by + bz * bz)
            thick, taper = radii[s, 0], radii[s, 1] - radii[s, 0]
            # No branch and no division inside, numbers side by side: compiled to several at once.
            for i in range(points.shape[1]):
                px, py, pz = x[i] - ax, y[i] - ay, z[i] - az
                t = min(1.0, max(0.0, (px * bx + py * by + pz * bz) * share))
                dx, dy, dz = px - t * bx, py - t * by, pz - t * bz
                off = math.sqrt(dx * dx + dy * dy + dz * dz) - (thick + t * taper)
                near[i] = min(near[i], abs(off))


@numba.njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def unexplained_sums(others: Any, own: Any, squared_scale: float, result: Any) -> None:
    """Fill sums (K,) of d^2 / (d^2 + s^2), d the lesser of others (N,) and own (K, N)."""
    for k in range(own.shape[0]):
        total = 0.0
        for i in range(own.shape[1]):
            d = min(others[i], own[k, i])
            total += d * d / (d * d + squared_scale)
        result[k] = total


@numba.njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def pair_sums(others: Any, left: Any, right: Any, squared_scale: float, result: Any) -> None:
    """Fill sums (K, L) of d^2 / (d^2 + s^2) for all pairs of left (K, N) and right (L, N)."""
    for k in range(left.shape[0]):
        for m in range(right.shape[0]):
            total = 0.0
            for i in range(others.shape[0]):
                d = min(others[i], left[k, i], right[m, i])
                total += d * d / (d * d + squared_scale)
            result[k, m] = total


@numba.njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def count_sight(
    points: Any,
    radius: Any,
    image: Any,
    silhouette: Any,
    pinhole: Any,
    see_through: float,
    support: float,
    seen: Any,
) -> None:
    """Count for every point how one view judges it.

    Parameters
    ----------
    points : (M, 3) float64
        On the arms' axes, in the frame of the depth camera.
    radius : (M,) float64, metres
        The surface lies nearer to the camera by this.
    image : (H, W) float32
        Range along z, NaN where not known.
    silhouette : (H, W) bool, or (0, 0) where it is not known
    pinhole : (3,) float64
        Focal length and principal point.
    see_through, support : float, 1/metres
        Differences of inverse range.
    seen : (M, 4) int64
        Counters: seen through, supported, hidden, inside the silhouette without a range.
    """
    height, width = image.shape
    for i in range(points.shape[0]):
        z = points[i, 2] - radius[i]
        if z < 0.1:
            continue
        u = round(pinhole[0] * points[i, 0] / points[i, 2] + pinhole[1])
        v = round(pinhole[0] * points[i, 1] / points[i, 2] + pinhole[2])
        if u < 0 or v < 0 or u >= width or v >= height:
            continue
        measured = image[v, u]
        if not measured > 0.0:
            if silhouette.shape[0] > 0:
                seen[i, 3 if silhouette[v, u] else 0] += 1
            continue
        difference = 1.0 / measured - 1.0 / z
        if difference < -see_through:
            seen[i, 0] += 1
        elif abs(difference) < support:
            seen[i, 1] += 1
        elif difference > 0.0:
            seen[i, 2] += 1


@numba.njit(cache=True, nogil=True, error_model="numpy")  # type: ignore[untyped-decorator]
def anatomy_costs(
    upper: Any, fore: Any, mirrored: float, places: Any, cone: Any, result: Any
) -> None:
    """Fill costs (K,) of elbows bent too far, arms inside the torso, and where arms cannot be.

    Parameters
    ----------
    upper, fore : (K, 3) float64
        Unit vectors along the arms, torso's frame.
    mirrored : float
        -1 for left arms, 1 for right ones.
    places : (K, P, 3) float64, metres
        Beyond the elbows, in the frame of the torso's cone.
    cone : (6,) float64
        Of the torso, see :attr:`Cones.sizes`.
    """
    r1, r2, height, flat = cone[0], cone[1], cone[2], cone[3]
    for k in range(upper.shape[0]):
        ux, uy, uz = mirrored * upper[k, 0], upper[k, 1], upper[k, 2]
        fx, fy, fz = mirrored * fore[k, 0], fore[k, 1], fore[k, 2]
        along = ux * fx + uy * fy + uz * fz
        cx, cy, cz = uy * fz - uz * fy, uz * fx - ux * fz, ux * fy - uy * fx
        bend = math.atan2(math.sqrt(cx * cx + cy * cy + cz * cz), along)
        cost = 12.0 * _steps((bend - _FOLDED) / _FOLDING)
        cost += 6.0 * _steps((-uy - 0.55) / 0.25) + 6.0 * _steps((-ux - 0.60) / 0.25)
        if uz < 0.4:
            cost += 6.0 * _steps((along * uy - fy - 0.40) / 0.30)
        for i in range(places.shape[1]):
            x, y, z = places[k, i, 0], places[k, i, 1], places[k, i, 2]
            if 0.0 <= z <= height:
                out = math.sqrt(x * x + (y / flat) * (y / flat))
                off = out - r1 - (r2 - r1) * z / height
                cost += 3.0 * _steps((_DEEP - (flat * off if out > 0.0 else off)) / 0.03)
        result[k] = cost


@numba.njit(cache=True, nogil=True, inline="always")  # type: ignore[untyped-decorator]
def _steps(excess: float) -> float:
    """An excess in units of its step, between none and two."""
    return min(2.0, max(0.0, excess))
