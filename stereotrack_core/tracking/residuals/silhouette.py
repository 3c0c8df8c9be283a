"""Silhouettes as residuals of the same kind as those of the cloud's points.

Block matching widens thin limbs and pulls at their ranges; the edge of what differs from the empty
scene is sharp to about a pixel. An outline of the model that borders on background is measured
against the nearest edge in that view.
"""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stereotrack_core.body.manifold import OUTLINE
from stereotrack_core.body.model import BodyModel, placed_cones
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.body.skeleton import (
    ARM_PARTS,
    CLAVICLES,
    FOREARMS,
    HEAD,
    PARTS,
    TORSO,
    UPPER_ARMS,
)
from stereotrack_core.body.surface import ClosestPoints, in_cone, parts_of_cones, places_for
from stereotrack_core.compiled import compiled
from stereotrack_core.depth.cloud import Cloud, EdgeMap
from stereotrack_core.tracking.residuals.surface import SurfaceResidual, Trust, residual_of_closest

FARTHEST = 0.15  # metres from every edge; beyond, the contour's edge is another part's
EFFECTIVE = 120.0  # sample size of a frame set's contours: neighbours share their errors
EFFECTIVE_WITHOUT_RANGE = 24.0  # the same of views without ranges, which confuse parts
_LOSS_SCALE = 0.06  # metres at which a contour weighs a quarter, as the cloud's points
_DEPTH = 0.15  # metres by which an edge's range may differ from the contour's; more is another part


def edge_maps(cloud: Cloud) -> tuple[EdgeMap, ...]:
    """Maps of the views that know their outline."""
    return tuple(depth.edges for depth in cloud.depths.values() if depth.edges is not None)


_BESIDE = 0.04  # metres beside an outline that no other part may cover
_SLOPE = 1.5  # pixels over which the slope of the distances is taken
_OUTWARDS = 0.3  # least cosine between the edge's and the outline's outward directions
_SHARED = 2.5  # pixels between an edge and an outline of the trunk, which may be its own
_INSIDE = 3.0  # pixels inside of an edge where its range is read
# Legs are left to the cloud: their cones are too rough to be measured at the edge.
MEASURED_PARTS = (TORSO, *CLAVICLES, HEAD, *UPPER_ARMS, *FOREARMS)
_MEASURED = np.isin(np.arange(len(PARTS)), MEASURED_PARTS)
_LIMB = np.isin(np.arange(len(PARTS)), ARM_PARTS)
_ALONG = np.array([0.1, 0.3, 0.5, 0.7, 0.9])  # along a cone where its outline is measured; 0: base


def contours_of(edges: tuple[EdgeMap, ...], body: BodyModel, frames: PartFrames) -> ClosestPoints:
    """Measure the contours of one pose against the edges of all views near them.

    The points lie on the surface where a view grazes it, with their margins; distances to the edge
    are positive outwards, across the line of sight.
    """
    placed, n = placed_cones(body, frames), 0
    seen = places_for(2 * len(_ALONG) * len(placed) * len(edges))
    for edge in edges:
        view = edge.distance, edge.range_z, edge.pinhole, edge.camera_from_world
        n = _measure_outline(placed, view, n, seen)
    cone, distance, point, direction = seen
    return ClosestPoints(cone[:n], distance[:n], point[:n], direction[:n])


@dataclass(frozen=True, eq=False)
class SilhouetteObservation:
    """The edges of one instant, against which outlines are measured."""

    edges: tuple[EdgeMap, ...]
    sigma: float  # Metres. Standard deviation of a contour's distance from its edge.
    effective: float = EFFECTIVE  # effective sample size of all contours of a frame set

    def residuals(self, body: BodyModel, pose: Pose) -> tuple[SurfaceResidual, ...]:
        """Distances between the outlines of a pose and the edges near them."""
        if not self.edges:
            return ()
        frames = body.frames(pose)
        seen = contours_of(self.edges, body, frames)
        trust = Trust(FARTHEST, _LOSS_SCALE, self.sigma, self.effective)
        data = seen.point + seen.distance[:, None] * seen.direction
        found = residual_of_closest(data, parts_of_cones(body, seen.cone), seen, frames, trust)
        return (replace(found, kind=OUTLINE),)


def silhouettes_of(cloud: Cloud, sigma: float) -> SilhouetteObservation:
    """What the silhouettes of an instant measure, each contour with this deviation, metres."""
    effective = EFFECTIVE if cloud.view_names else EFFECTIVE_WITHOUT_RANGE
    return SilhouetteObservation(edge_maps(cloud), sigma, effective)


@compiled(inline="always")
def _grazed(cone: Any, ex: float, ey: float, ez: float, u: float, side: float) -> Any:
    """Place on a cone's surface, its own frame, that a camera at (ex, ey, ez), world, grazes.

    The flattened cone is round in stretched coordinates, and touching survives stretching; the
    taper and the perspective within a cone's width are neglected.
    """
    s = cone.flatness
    wx, wy, _ = in_cone(cone, ex, ey, ez)
    wy = wy / s
    norm = max(math.sqrt(wx * wx + wy * wy), 1e-9)
    radius = cone.r1 + u * (cone.r2 - cone.r1)
    return -side * radius * wy / norm, side * s * radius * wx / norm, u * cone.height


@compiled(inline="always")
def _seen(cone: Any, place: Any, pinhole: Any, x: float, y: float, z: float) -> Any:
    """World (3), column, row and range of a place (x, y, z) in a cone's frame."""
    R, origin = cone.rotation, cone.origin
    px = R[0, 0] * x + R[0, 1] * y + R[0, 2] * z + origin[0]
    py = R[1, 0] * x + R[1, 1] * y + R[1, 2] * z + origin[1]
    pz = R[2, 0] * x + R[2, 1] * y + R[2, 2] * z + origin[2]
    a = place[0, 0] * px + place[0, 1] * py + place[0, 2] * pz + place[0, 3]
    b = place[1, 0] * px + place[1, 1] * py + place[1, 2] * pz + place[1, 3]
    c = place[2, 0] * px + place[2, 1] * py + place[2, 2] * pz + place[2, 3]
    near = max(c, 1e-6)
    return px, py, pz, pinhole[0] * a / near + pinhole[1], pinhole[0] * b / near + pinhole[2], c


@compiled()
def _capsules(placed: Any, place: Any, pinhole: Any, eye: Any, capsules: Any) -> None:
    """Fill the cones' images (C, 7): two ends with radii in pixels, and whether in front."""
    for c in range(placed.shape[0]):
        cone, front = placed[c], 1.0
        for end in range(2):
            x, y, z = _grazed(cone, eye[0], eye[1], eye[2], float(end), 1.0)
            _, _, _, u1, v1, z1 = _seen(cone, place, pinhole, x, y, z)
            _, _, _, u2, v2, z2 = _seen(cone, place, pinhole, -x, -y, z)
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
def _shared(placed: Any, capsules: Any, u: float, v: float) -> Any:
    """Whether the outline of the trunk, the head or a leg lies at an edge as well."""
    for c in range(capsules.shape[0]):
        if _LIMB[placed[c].part] or capsules[c, 6] < 0.5:
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
    """Distance to the nearest edge, pixels; outward direction (2), zero if that is unclear."""
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
def _measure_outline(placed: Any, view: Any, n: int, out_seen: Any) -> int:
    """Append the outlines of one view to the first n places that were seen, return their number.

    Edges at which the trunk ends as well say nothing about a limb. The outline lies outside of the
    surface by a margin along the cones' x and y. `view` are the fields of an :class:`EdgeMap`.
    """
    edge, range_z, pinhole, place = view
    out_cone, out_distance, out_point, out_direction = out_seen
    capsules, eye = np.empty((placed.shape[0], 7)), _centre(place)
    _capsules(placed, place, pinhole, eye, capsules)
    height, width = edge.shape
    for c in range(placed.shape[0]):
        cone, image, limb = placed[c], capsules[c], _LIMB[placed[c].part]
        if not _MEASURED[cone.part] or image[6] < 0.5:
            continue
        for a in range(_ALONG.shape[0]):
            t = _ALONG[a]
            middle_u = image[0] + t * (image[3] - image[0])
            middle_v = image[1] + t * (image[4] - image[1])
            for k in range(2):
                x, y, z = _grazed(cone, eye[0], eye[1], eye[2], t, 1.0 - 2.0 * k)
                px, py, pz, column, line, depth = _seen(cone, place, pinhole, x, y, z)
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
                value, gu, gv = _edge_near(edge, range_z, u, v, depth, _DEPTH)
                if not gu * du + gv * dv > _OUTWARDS:
                    continue
                if limb and _shared(placed, capsules, column - value * gu, line - value * gv):
                    continue
                w = (gu * (column - pinhole[1]) + gv * (line - pinhole[2])) / pinhole[0]
                scale = math.sqrt(1.0 + w * w)
                margin = cone.outline[0] * x * x + cone.outline[1] * y * y
                away = -value * depth / pinhole[0] / scale - margin / (x * x + y * y)
                if not abs(away) < FARTHEST:
                    continue
                out_cone[n], out_distance[n] = c, away
                out_point[n, 0], out_point[n, 1], out_point[n, 2] = px, py, pz
                for j in range(3):
                    toward = place[0, j] * gu + place[1, j] * gv - place[2, j] * w
                    out_direction[n, j] = toward / scale
                n += 1
    return n
