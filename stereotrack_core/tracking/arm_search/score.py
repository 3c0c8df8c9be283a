"""What speaks for and against an arm (docs/method.md 4.9)."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import PartFrames
from stereotrack_core.body.skeleton import TORSO
from stereotrack_core.compiled import compiled
from stereotrack_core.depth.cloud import ViewDepth
from stereotrack_core.geometry.rotation import angle_between
from stereotrack_core.geometry.triangulation import segment_distance
from stereotrack_core.tracking.arm_search.arms import LEFT, Arms, ArmShape

_ALONG = np.linspace(0.0, 3.0, 11)[2:]
"""Nine places along the arm: 0 shoulder, 1 elbow, 2 wrist, 3 finger tip."""

_BEYOND_ELBOW = 2
"""The first of them that is beyond the elbow."""

_SEGMENT = np.minimum(_ALONG.astype(int), 2)
_T = _ALONG - _SEGMENT
_SHARES = np.eye(4)[_SEGMENT] * (1.0 - _T)[:, None] + np.eye(4)[_SEGMENT + 1] * _T[:, None]
"""Shares (9, 4) of the nodes in these places."""

_SEE_THROUGH_PX, _SUPPORT_PX = 1.3, 0.9
"""Pixels of disparity from which a view looks through a place, and up to which it supports it: a
little more than the matcher's errors."""

SEEN_THROUGH, UNSUPPORTED = 2.5, 1.5
"""Costs of a place that a view looks through, at most two views counting, and of one that no view
supports or hides; in data explained, as all of the search's costs."""

_FILLED, _ONLY_HIDDEN = 0.25, 0.75
"""Costs of a place inside a silhouette where no view has a range, and of one that all views have
something in front of: less, for nothing speaks against an arm there (docs/accuracy.md)."""

_UPPER, _FORE = (0, 1), (1, 3)
"""First and last node of an upper arm, and of a forearm with its hand."""

_UNKNOWN = np.zeros((0, 0), dtype=np.bool_)

_DEEP = -0.03
"""Metres from the torso's surface, negative inside, from which an arm's axis is too deep: bodies
give way where arms lie on them."""

_FOLDED, _FOLDING = math.radians(140.0), math.radians(15.0)


def sight_of(depths: Iterable[ViewDepth], places: FloatArray, radius: FloatArray) -> IntArray:
    """How many views look through, support, hide or have no range at each place (M, 4).

    Parameters
    ----------
    depths : iterable of ViewDepth
    places : (M, 3) float64, world
    radius : (M,) float64, metres
        The surface lies nearer to the cameras by this.
    """
    seen = np.zeros((len(places), 4), dtype=np.int64)
    for depth in depths:
        g = depth.geometry
        pinhole = np.array([g.focal, g.c_x, g.c_y])
        in_camera = g.world_from_depth.inverse().apply(places)
        silhouette = _UNKNOWN if depth.silhouette is None else depth.silhouette
        limits = _SEE_THROUGH_PX / g.disparity_scale, _SUPPORT_PX / g.disparity_scale
        _count_sight(in_camera, radius, depth.range_z, silhouette, pinhole, *limits, seen)
    return seen


def sight_cost(
    frames: PartFrames, depths: Iterable[ViewDepth], shape: ArmShape, arms: Arms
) -> FloatArray:
    """Cost (K,) of places where views look through the arm, or where no view supports it.

    Pixels without a range prove nothing by themselves; inside the silhouette they weakly support,
    outside of it they are looked through.
    """
    of_segments = shape.radii[_SEGMENT]
    radii = of_segments[:, 0] * (1.0 - _T) + of_segments[:, 1] * _T
    places = _SHARES @ shape.nodes(arms)
    world = places.reshape(-1, 3) @ frames.rotations[TORSO].T + frames.origins[TORSO]
    seen = sight_of(depths, world, np.tile(radii, len(arms)))
    through, supported, hidden, filled = seen.reshape(len(arms), -1, 4).transpose(2, 0, 1)
    unsupported = np.where(hidden > 0, _ONLY_HIDDEN, UNSUPPORTED)
    unsupported = np.where(filled > 0, _FILLED, unsupported)
    cost = SEEN_THROUGH * np.minimum(through, 2) + np.where(supported > 0, 0.0, unsupported)
    result: FloatArray = cost.sum(axis=1)
    return result


def anatomy_cost(body: BodyModel, shape: ArmShape, arms: Arms) -> FloatArray:
    """Cost (K,) of elbows bent too far, arms inside the torso, and arms where arms cannot be."""
    cones = body.cones
    places = _SHARES[_BEYOND_ELBOW:] @ shape.nodes(arms)
    in_cone = (places - cones.origins[0]) @ cones.rotations[0]
    cost = np.empty(len(arms))
    mirrored = -1.0 if shape.side == LEFT else 1.0
    _anatomy_costs(arms.upper, arms.fore, mirrored, in_cone, cones.sizes[0], cost)
    return cost


def change_cost(predicted: Arms, arms: Arms) -> FloatArray:
    """Cost (K,) of the change against the predicted arm."""
    upper = np.degrees(angle_between(arms.upper, predicted.upper)) / 30.0
    fore = np.degrees(angle_between(arms.fore, predicted.fore)) / 40.0
    return 2.0 * (np.log1p(upper**2) + np.log1p(fore**2))


def crossing_cost(left: FloatArray, right: FloatArray, least: float) -> FloatArray:
    """Cost (K, L) of pairs of arms that go through each other.

    Parameters
    ----------
    left, right : (K, 4, 3) and (L, 4, 3) float64, torso's frame
        Nodes of arms, see :meth:`ArmShape.nodes`.
    least : float, metres
        Least distance of the forearms' axes, see :mod:`residuals.limits`; 0: none.
    """
    total: FloatArray = np.zeros((len(left), len(right)))
    if least <= 0.0:
        return total
    one, two = left[:, None], right[None]
    for (a, b), (c, d), room in ((_FORE, _FORE, 1.0), (_UPPER, _FORE, 2.0), (_FORE, _UPPER, 2.0)):
        apart = segment_distance(one[..., a, :], one[..., b, :], two[..., c, :], two[..., d, :])
        total += 3.0 * np.clip((room * least - apart) / 0.03, 0.0, 2.0)
    return total


@compiled(error_model="numpy")
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


@compiled()
def unexplained_sums(others: Any, own: Any, squared_scale: float, result: Any) -> None:
    """Fill sums (K,) of d^2 / (d^2 + s^2), d the lesser of others (N,) and own (K, N)."""
    for k in range(own.shape[0]):
        total = 0.0
        for i in range(own.shape[1]):
            d = min(others[i], own[k, i])
            total += d * d / (d * d + squared_scale)
        result[k] = total


@compiled()
def pair_sums(others: Any, left: Any, right: Any, squared_scale: float, result: Any) -> None:
    """Fill sums (K, L) of d^2 / (d^2 + s^2) for all pairs of left (K, N) and right (L, N)."""
    for k in range(left.shape[0]):
        for m in range(right.shape[0]):
            total = 0.0
            for i in range(others.shape[0]):
                d = min(others[i], left[k, i], right[m, i])
                total += d * d / (d * d + squared_scale)
            result[k, m] = total


@compiled()
def _count_sight(
    points: Any,
    radius: Any,
    image: Any,
    silhouette: Any,
    pinhole: Any,
    see_through: float,
    support: float,
    seen: Any,
) -> None:
    """Add to the counters (M, 4) how one view judges every point.

    `points` (M, 3) are in the frame of the depth camera, and the surface lies nearer to it by
    `radius` (M,); `image` (H, W) are ranges along z, NaN where not known; `silhouette` is (0, 0)
    where it is not known; `see_through` and `support` are differences of inverse range.
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


@compiled(error_model="numpy")
def _anatomy_costs(
    upper: Any, fore: Any, mirrored: float, places: Any, cone: Any, result: Any
) -> None:
    """Fill costs (K,) of elbows bent too far, arms inside the torso, and where arms cannot be.

    `upper` and `fore` (K, 3) are directions in the torso's frame, `mirrored` is -1 for left arms;
    `places` (K, P, 3), beyond the elbows, are in the frame of the torso's `cone`.
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


@compiled(inline="always")
def _steps(excess: float) -> float:
    """An excess in units of its step, between none and two."""
    return min(2.0, max(0.0, excess))
