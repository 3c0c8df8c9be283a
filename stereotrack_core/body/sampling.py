"""Points on the body's surface, and which of them cameras see, by closed formulas (3.2.2)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.body.model import BodyModel, Cones, PlacedCones, placed_cones
from stereotrack_core.body.pose import PartFrames

_SKIN = 1e-3  # metres that a segment must run free of the surface it starts on


def to_cone_frames(points: FloatArray, placed: PlacedCones) -> FloatArray:
    """Points (N, 3), world, in the frame of every cone (C, N, 3), y divided by the flatness."""
    shifted = points[None] - placed["origin"][:, None]
    local: FloatArray = np.einsum("cji,cnj->cni", placed["rotation"], shifted)
    local[..., 1] /= placed["flatness"][:, None]
    return local


def inside_other_cone(points: FloatArray, own: IntArray, placed: PlacedCones) -> BoolArray:
    """Which points (N, 3), world, lie inside another cone than their own, an index (N,)."""
    local, height = to_cone_frames(points, placed), placed["height"][:, None]
    z = local[..., 2]
    slope = ((placed["r2"] - placed["r1"]) / placed["height"])[:, None]
    radius = placed["r1"][:, None] + slope * z
    within = (z >= 0) & (z <= height)
    inside = within & (np.hypot(local[..., 0], local[..., 1]) < radius - _SKIN)
    inside[own, np.arange(len(points))] = False
    return np.asarray(np.logical_or.reduce(inside, axis=0))


def visible(
    points: FloatArray, normals: FloatArray, cameras: FloatArray, placed: PlacedCones
) -> BoolArray:
    """Which surface points (N,), world, face a camera (V, 3) that sees them past all cones."""
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

    With s(t) = p + t d in a cone's frame the side is met where x^2 + y^2 = (r1 + (r2 - r1)/H z)^2
    with 0 < t < 1 and 0 <= z <= H. A segment that enters by an end leaves by the side or by the
    other end; the shoulders' ends are not all covered.
    """
    p = to_cone_frames(points, placed)
    d = to_cone_frames(camera[None], placed) - p
    slope = ((placed["r2"] - placed["r1"]) / placed["height"])[:, None]
    radius = placed["r1"][:, None] + slope * p[..., 2]
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
        on_side = (z >= 0) & (z <= placed["height"][:, None]) & (radius + t * change > 0)
        blocked |= real & on_side & (t > 0) & (t < 1)
    with np.errstate(divide="ignore", invalid="ignore"):  # the discs at the bases
        t = -p[..., 2] / d[..., 2]
        across = np.hypot(p[..., 0] + t * d[..., 0], p[..., 1] + t * d[..., 1])
        blocked |= (t > 0) & (t < 1) & (across < placed["r1"][:, None])
    return np.asarray(np.logical_or.reduce(blocked, axis=0))


_ROUNDS = 12  # draws after which fewer points are accepted, as hardly anything is visible


@dataclass(frozen=True, eq=False)
class SurfacePoints:
    """Points (N, 3), metres, with outward unit normals, in the frames of their parts."""

    part: IntArray
    cone: IntArray
    points: FloatArray
    normals: FloatArray

    def __getitem__(self, index: BoolArray | IntArray | slice) -> SurfacePoints:
        return SurfacePoints(*(values[index] for values in vars(self).values()))

    def __len__(self) -> int:
        return len(self.part)


def points_on_cones(
    cones: Cones, cone: IntArray, h: FloatArray, alpha: FloatArray
) -> SurfacePoints:
    """Points p(h, alpha) (N,) of section 3.2.2 in the parts' frames; h is 0 to 1."""
    r1, r2, height, flat = (
        values[cone] for values in (cones["r1"], cones["r2"], cones["height"], cones["flatness"])
    )
    radius = r1 + h * (r2 - r1)
    cosine, sine = np.cos(alpha), np.sin(alpha)
    local = np.stack([radius * cosine, flat * radius * sine, h * height], axis=1)
    normal = np.stack([height * cosine, height * sine / flat, r1 - r2], axis=1)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    turn = cones["rotation"][cone]
    return SurfacePoints(
        part=cones["part"][cone],
        cone=cone,
        points=np.einsum("nij,nj->ni", turn, local) + cones["origin"][cone],
        normals=np.einsum("nij,nj->ni", turn, normal),
    )


def random_points(cones: Cones, count: int, rng: np.random.Generator) -> SurfacePoints:
    """Draw points with an equal share for every cone, uniform over height and angle."""
    cone = np.arange(count, dtype=np.int64) % len(cones)
    rng.shuffle(cone)
    return points_on_cones(cones, cone, rng.random(count), rng.random(count) * 2.0 * np.pi)


def regular_points(cones: Cones, count: int) -> SurfacePoints:
    """Spread points over every cone in a fixed pattern: golden-angle spirals."""
    cone = np.arange(count, dtype=np.int64) % len(cones)
    place = np.arange(count, dtype=np.int64) // len(cones)
    share = (place + 0.5) / (place[-1] + 1.0)
    golden = np.pi * (3.0 - np.sqrt(5.0))
    return points_on_cones(cones, cone, share, golden * place)


def visible_points(
    body: BodyModel,
    frames: PartFrames,
    cameras: FloatArray,
    count: int,
    rng: np.random.Generator | None,
    watch: Callable[[SurfacePoints, BoolArray, BoolArray], None] | None = None,
) -> SurfacePoints:
    """Sample the surface, without points inside another cone and points that no camera sees.

    The operator G of (3.4), for one pose, by optical centres (V, 3), world. Fewer than `count`
    points come back when hardly anything is visible. `rng` None takes a fixed pattern. `watch` is
    told of each draw: candidates, which are inside another cone, which of the others are seen.
    """
    placed = placed_cones(body, frames)

    def remaining(candidates: SurfacePoints) -> SurfacePoints:
        points = frames.apply(candidates.part, candidates.points)
        normals = np.einsum("nij,nj->ni", frames.rotations[candidates.part], candidates.normals)
        inside = inside_other_cone(points, candidates.cone, placed)
        keep = ~inside
        keep[keep] = visible(points[keep], normals[keep], cameras, placed)
        if watch is not None:
            watch(candidates, inside, keep)
        return candidates[keep]

    if rng is None:
        drawn = count
        kept = remaining(regular_points(body.cones, drawn))
        while len(kept) < count and drawn < count << 4:
            drawn = int(1.25 * drawn) + 1
            kept = remaining(regular_points(body.cones, drawn))
        return kept[np.linspace(0, len(kept) - 1, min(count, len(kept))).round().astype(np.int64)]
    kept = remaining(random_points(body.cones, 2 * count, rng))
    for _ in range(_ROUNDS):
        if len(kept) >= count:
            break
        more = remaining(random_points(body.cones, 2 * count, rng))
        pairs = zip(vars(kept).values(), vars(more).values(), strict=True)
        kept = SurfacePoints(*map(np.concatenate, pairs))
    return kept[:count]
