"""Silhouettes as residuals of the same kind as those of the cloud's points.

Block matching widens thin limbs and pulls at their ranges; the edge of what differs from the
empty scene is sharp to about a pixel. Where an outline of the model borders on background it is
measured against the nearest edge in that view.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from stereotrack_core.arrays import BoolArray, Float32Array, FloatArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.body.skeleton import CLAVICLES, FOREARMS, HEAD, PARTS, TORSO, UPPER_ARMS
from stereotrack_core.body.surface import ClosestPoints, cone_tables, parts_of_cones
from stereotrack_core.compiled import compiled
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.tracking.residuals.surface import SurfaceResidual, Trust, residual_of_closest

_LEAST_PATCH = 150
"""Pixels below which a patch of the silhouette is noise."""

FARTHEST = 0.15
"""Metres from every edge beyond which a contour is not used: its edge is another part's."""

EFFECTIVE = 120.0
"""Effective sample size of the contours of a frame set: neighbours share their part's errors."""

EFFECTIVE_WITHOUT_RANGE = 24.0
"""The same where no view measures ranges, so that more contours are taken for another part's."""

_LOSS_SCALE = 0.06
"""Metres at which a contour loses three quarters of its weight, as the cloud's points do."""

_DEPTH = 0.15
"""Metres by which an edge's range may differ from the contour's; more is another part."""

_AROUND = 32
"""Pixels around a silhouette in which outlines are still measured."""


@dataclass(frozen=True, eq=False)
class EdgeMap:
    """Distances from the silhouette's edge in one view, around the person."""

    distance: Float32Array
    """(h, w), pixels. Positive outside of the silhouette, negative inside."""
    range_z: Float32Array
    """(h, w), metres. NaN where not known."""
    pinhole: FloatArray
    """(5,). Focal length, principal point, and the place of the map's first pixel in the image."""
    camera_from_world: FloatArray
    """(3, 4). Rotation and translation."""


def edge_maps(cloud: Cloud) -> tuple[EdgeMap, ...]:
    """Maps of the views that know their outline."""
    maps = []
    for depth in cloud.depths.values():
        found = None if depth.outline is None else _signed_distances(depth.outline)
        if found is None:
            continue
        g, (distance, left, top) = depth.geometry, found
        height, width = distance.shape
        to_camera = g.world_from_depth.inverse()
        maps.append(
            EdgeMap(
                distance=distance,
                range_z=np.ascontiguousarray(
                    depth.range_z[top : top + height, left : left + width]
                ),
                pinhole=np.array([g.focal, g.c_x, g.c_y, left, top], dtype=np.float64),
                camera_from_world=to_camera.matrix()[:3],
            )
        )
    return tuple(maps)


def _signed_distances(outline: BoolArray) -> tuple[Float32Array, int, int] | None:
    """Signed distances around the larger patches, and the left and top of that region."""
    patches = outline.astype(np.uint8)
    cv2.filterSpeckles(patches, 0, _LEAST_PATCH - 1, 0)
    left, top, width, height = cv2.boundingRect(patches)
    if not width:
        return None
    right, bottom = left + width, top + height
    person = patches[top:bottom, left:right]
    height, width = outline.shape
    before = min(_AROUND, top), min(_AROUND, left)
    after = min(_AROUND, height - bottom), min(_AROUND, width - right)
    inside = np.pad(person, tuple(zip(before, after, strict=True)))
    outward = cv2.distanceTransform(1 - inside, cv2.DIST_L2, 5)
    inward = cv2.distanceTransform(inside, cv2.DIST_L2, 5)
    # Both count to the middle of a pixel on the other side; the edge runs half a pixel before it.
    half = 0.5 - inside.astype(np.float32)
    distance: Float32Array = np.ascontiguousarray(outward - inward - half, dtype=np.float32)
    return distance, left - before[1], top - before[0]


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

MEASURED_PARTS = (TORSO, *CLAVICLES, HEAD, *UPPER_ARMS, *FOREARMS)
"""Legs are left to the cloud: their cones are too rough to be measured at the edge."""

_MEASURED = np.isin(np.arange(len(PARTS)), MEASURED_PARTS)
_LIMB = np.isin(np.arange(len(PARTS)), (*UPPER_ARMS, *FOREARMS))

_ALONG = np.array([0.1, 0.3, 0.5, 0.7, 0.9])
"""Places along a cone where its outline is measured; 0 is the base."""


def contours_of(
    edges: tuple[EdgeMap, ...], body: BodyModel, frames: PartFrames, farthest: float = FARTHEST
) -> ClosestPoints:
    """Measure the contours of one pose against the edges of all views, within so many metres.

    The points lie on the surface where a view grazes it, with their margins; distances to the edge
    are positive outwards, across the line of sight.
    """
    table = cone_tables(body.cones, frames)
    measured, limb = _MEASURED[body.cones.part], _LIMB[body.cones.part]
    room = 2 * len(_ALONG) * len(table)
    found = []
    for edge in edges:
        cone, distance = np.empty(room, dtype=np.int64), np.empty(room)
        point, direction = np.empty((room, 3)), np.empty((room, 3))
        n = _measure_outline(
            table,
            measured,
            limb,
            body.cones.outline,
            edge.distance,
            edge.range_z,
            edge.pinhole,
            edge.camera_from_world,
            _ALONG,
            _DEPTH,
            point,
            direction,
            distance,
            cone,
        )
        kept = np.flatnonzero(np.abs(distance[:n]) < farthest)
        found.append((cone[kept], distance[kept], point[kept], direction[kept]))
    if not found:
        nowhere = np.empty((0, 3))
        return ClosestPoints(np.empty(0, dtype=np.int64), np.empty(0), nowhere, nowhere)
    return ClosestPoints(*(np.concatenate(values) for values in zip(*found, strict=True)))


@dataclass(frozen=True, eq=False)
class SilhouetteObservation:
    """The edges of one instant, against which outlines are measured."""

    edges: tuple[EdgeMap, ...]
    sigma: float
    """Metres. Standard deviation of a contour's distance from its edge."""
    effective: float = EFFECTIVE
    """Effective sample size of all contours of a frame set."""

    def residuals(self, body: BodyModel, pose: Pose) -> tuple[SurfaceResidual, ...]:
        """Distances between the outlines of a pose and the edges near them."""
        if not self.edges:
            return ()
        frames = body.frames(pose)
        seen = contours_of(self.edges, body, frames)
        trust = Trust(FARTHEST, _LOSS_SCALE, self.sigma, self.effective)
        data = seen.point + seen.distance[:, None] * seen.direction
        return (residual_of_closest(data, parts_of_cones(body, seen.cone), seen, frames, trust),)


def silhouettes_of(cloud: Cloud, sigma: float) -> SilhouetteObservation:
    """What the silhouettes of an instant measure, each contour with this deviation, metres."""
    effective = EFFECTIVE if cloud.view_names else EFFECTIVE_WITHOUT_RANGE
    return SilhouetteObservation(edge_maps(cloud), sigma, effective)


@compiled(inline="always")
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


@compiled(inline="always")
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


@compiled()
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


@compiled(inline="always")
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


@compiled(inline="always")
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


@compiled(inline="always")
def _at(image: Any, u: float, v: float) -> Any:
    i, j = int(v), int(u)
    a, b = v - i, u - j
    upper = (1.0 - b) * image[i, j] + b * image[i, j + 1]
    lower = (1.0 - b) * image[i + 1, j] + b * image[i + 1, j + 1]
    return (1.0 - a) * upper + a * lower


@compiled(inline="always")
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


@compiled()
def _centre(place: Any) -> Any:
    """World place (3,) of the camera with camera_from_world `place`."""
    eye = np.empty(3)
    for k in range(3):
        eye[k] = -(
            place[0, k] * place[0, 3] + place[1, k] * place[1, 3] + place[2, k] * place[2, 3]
        )
    return eye


@compiled()
def _measure_outline(
    table: Any,
    measured: Any,
    limb: Any,
    margin: Any,
    edge: Any,
    range_z: Any,
    pinhole: Any,
    place: Any,
    along: Any,
    farthest: float,
    point: Any,
    direction: Any,
    distance: Any,
    cone: Any,
) -> int:
    """Fill the outlines of one view and return how many there are.

    Of the cones `table` (C, 18) those that are `measured` (C,) are wanted; edges at which the trunk
    ends as well say nothing about a `limb` (C,). The outline lies by `margin` (C, 2) outside of the
    surface along the cones' x and y. `edge`, `range_z`, `pinhole` and `place` are those of an
    :class:`EdgeMap`, `along` (A,) are places along a cone, 0 at its base. The four arrays that are
    filled have 2 C A rows, see :func:`contours_of`.
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
                value, gu, gv = _edge_near(edge, range_z, u, v, depth, farthest)
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
                point[n, 0], point[n, 1], point[n, 2], cone[n] = px, py, pz, c
                n += 1
    return n
