"""What of the body's surface a camera can see: closed formulas, no z-buffer (section 3.2.2)."""

from __future__ import annotations

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.cones import Cones
from stereotrack_core.body.model import PlacedCones

_SKIN = 1e-3
"""Metres that a segment must run free of the surface it starts on."""


def to_cone_frames(points: FloatArray, placed: PlacedCones) -> FloatArray:
    """Points (N, 3), world, in the frame of every cone (C, N, 3), y divided by the flatness."""
    shifted = points[None] - placed.origins[:, None]
    local: FloatArray = np.einsum("cji,cnj->cni", placed.rotations, shifted)
    local[..., 1] /= placed.cones.flatness[:, None]
    return local


def inside_other_cone(points: FloatArray, own: IntArray, placed: PlacedCones) -> BoolArray:
    """Which points (N,) lie inside a cone that is not their own.

    Parameters
    ----------
    points : (N, 3) float64, world
    own : (N,) int64
        Index of the cone that each point was sampled from.
    placed : PlacedCones
    """
    cones = placed.cones
    local = to_cone_frames(points, placed)
    z = local[..., 2]
    slope = ((cones.r2 - cones.r1) / cones.height)[:, None]
    radius = cones.r1[:, None] + slope * z
    within = (z >= 0) & (z <= cones.height[:, None])
    inside = within & (np.hypot(local[..., 0], local[..., 1]) < radius - _SKIN)
    inside[own, np.arange(len(points))] = False
    result: BoolArray = np.logical_or.reduce(inside, axis=0)
    return result


def visible(
    points: FloatArray, normals: FloatArray, cameras: FloatArray, placed: PlacedCones
) -> BoolArray:
    """Which surface points (N,) at least one camera sees.

    A point is seen when its surface faces the camera and the segment to the camera meets no cone.

    Parameters
    ----------
    points, normals : (N, 3) float64, world
        Points on the surface and outward normals there.
    cameras : (V, 3) float64, world
        Optical centres.
    placed : PlacedCones
    """
    seen: BoolArray = np.zeros(len(points), dtype=np.bool_)
    for camera in cameras:
        sight = camera - points
        faces = np.einsum("ni,ni->n", normals, sight) > 0
        candidates = np.flatnonzero(faces & ~seen)
        if len(candidates):
            start = points[candidates] + _SKIN * normals[candidates]
            seen[candidates] = ~segment_blocked(start, camera, placed)
    return seen


def segment_blocked(points: FloatArray, camera: FloatArray, placed: PlacedCones) -> BoolArray:
    """Whether the segments (N,) from points (N, 3) to a camera (3,) meet any cone.

    With s(t) = p + t d in a cone's frame the side is met where
    x^2 + y^2 = (r1 + (r2 - r1)/H z)^2 with 0 < t < 1 and 0 <= z <= H. A segment that enters
    by an end leaves by the side or by the other end; the shoulders' ends are not all covered.
    """
    p = to_cone_frames(points, placed)
    d = to_cone_frames(camera[None], placed) - p
    blocked = _meets_side(p, d, placed.cones) | _meets_base(p, d, placed.cones)
    result: BoolArray = np.logical_or.reduce(blocked, axis=0)
    return result


def _meets_side(p: FloatArray, d: FloatArray, cones: Cones) -> BoolArray:
    """Whether p + t d (C, N, 3), y divided by the flatness, meets the cones' sides (C, N)."""
    slope = ((cones.r2 - cones.r1) / cones.height)[:, None]
    radius = cones.r1[:, None] + slope * p[..., 2]
    change = slope * d[..., 2]
    a = d[..., 0] ** 2 + d[..., 1] ** 2 - change**2
    half_b = p[..., 0] * d[..., 0] + p[..., 1] * d[..., 1] - radius * change
    e = p[..., 0] ** 2 + p[..., 1] ** 2 - radius**2
    root = np.sqrt(np.maximum(half_b**2 - a * e, 0.0))
    real = (half_b**2 - a * e > 0) & (np.abs(a) > 1e-12)
    blocked: BoolArray = np.zeros(p.shape[:2], dtype=np.bool_)
    for sign in (-1.0, 1.0):
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (-half_b + sign * root) / a
            z = p[..., 2] + t * d[..., 2]
        on_side = (z >= 0) & (z <= cones.height[:, None]) & (radius + t * change > 0)
        blocked |= real & on_side & (t > 0) & (t < 1)
    return blocked


def _meets_base(p: FloatArray, d: FloatArray, cones: Cones) -> BoolArray:
    """Whether p + t d (C, N, 3) meets the discs at the cones' bases (C, N).

    The discs at the other ends need no look: whatever enters there leaves elsewhere.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        t = -p[..., 2] / d[..., 2]
        across = np.hypot(p[..., 0] + t * d[..., 0], p[..., 1] + t * d[..., 1])
        result: BoolArray = (t > 0) & (t < 1) & (across < cones.r1[:, None])
    return result
