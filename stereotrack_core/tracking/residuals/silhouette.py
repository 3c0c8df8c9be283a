"""Silhouettes as residuals of the same kind as those of the cloud's points.

Block matching widens thin limbs and pulls at their ranges; the edge of what differs from the
empty scene is sharp to about a pixel. Where an outline of the model borders on background it is
measured against the nearest edge in that view.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from stereotrack_core.arrays import BoolArray, Float32Array, FloatArray, IntArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.body.skeleton import CLAVICLES, FOREARMS, HEAD, PARTS, TORSO, UPPER_ARMS
from stereotrack_core.body.surface import ClosestPoints, cone_tables, parts_of_cones
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.tracking.residuals.silhouette_kernels import measure_outline
from stereotrack_core.tracking.residuals.surface import SurfaceResidual, Trust, residual_of_closest

_LEAST_PATCH = 150
"""Pixels below which a patch of the silhouette is noise."""

FARTHEST = 0.15
"""Metres from every edge beyond which a contour is not used: its edge is another part's."""

EFFECTIVE = 120.0
"""Effective sample size of the contours of a frame set: neighbours share their part's errors."""

_LOSS_SCALE = 0.06
"""Metres at which a contour loses three quarters of its weight, as the cloud's points do."""

_DEPTH = 0.15
"""Metres by which an edge's range may differ from the contour's; more is another part."""

_AROUND = 32
"""Pixels around a silhouette in which outlines are still measured."""


@dataclass(frozen=True, eq=False)
class EdgeMap:
    """Distances from the silhouette's edge in one view, around the person.

    Attributes
    ----------
    distance : (h, w) float32, pixels
        Positive outside of the silhouette, negative inside.
    range_z : (h, w) float32, metres
        NaN where not known.
    pinhole : (5,) float64
        Focal length, principal point, and the place of the map's first pixel in the image.
    camera_from_world : (3, 4) float64
        Rotation and translation.
    """

    distance: Float32Array
    range_z: Float32Array
    pinhole: FloatArray
    camera_from_world: FloatArray


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
    x, y, width, height = cv2.boundingRect(outline.view(np.uint8))
    if not width:
        return None
    cut = outline[y : y + height, x : x + width].astype(np.uint8)
    count, found, stats, _ = cv2.connectedComponentsWithStats(cut)
    large = np.flatnonzero(stats[1:, cv2.CC_STAT_AREA] >= _LEAST_PATCH) + 1
    if not len(large):
        return None
    left, top = (int(low) for low in stats[large, :2].min(axis=0))
    right, bottom = (int(high) for high in (stats[large, :2] + stats[large, 2:4]).max(axis=0))
    keep = np.zeros(count, dtype=np.uint8)
    keep[large] = 1
    person = keep[found[top:bottom, left:right]]
    height, width = outline.shape
    left, top, right, bottom = left + x, top + y, right + x, bottom + y
    before = min(_AROUND, top), min(_AROUND, left)
    after = min(_AROUND, height - bottom), min(_AROUND, width - right)
    inside = np.pad(person, tuple(zip(before, after, strict=True)))
    outward = cv2.distanceTransform(1 - inside, cv2.DIST_L2, 5)
    inward = cv2.distanceTransform(inside, cv2.DIST_L2, 5)
    # Both count to the middle of a pixel on the other side; the edge runs half a pixel before it.
    half = 0.5 - inside.astype(np.float32)
    distance: Float32Array = np.ascontiguousarray(outward - inward - half, dtype=np.float32)
    return distance, left - before[1], top - before[0]


MEASURED_PARTS = (TORSO, *CLAVICLES, HEAD, *UPPER_ARMS, *FOREARMS)
"""Legs are left to the cloud: their cones are too rough to be measured at the edge."""

_MEASURED = np.isin(np.arange(len(PARTS)), MEASURED_PARTS)
_LIMB = np.isin(np.arange(len(PARTS)), (*UPPER_ARMS, *FOREARMS))

_ALONG = np.array([0.1, 0.3, 0.5, 0.7, 0.9])
"""Places along a cone where its outline is measured; 0 is the base."""


@dataclass(frozen=True, eq=False)
class Contours:
    """Outlines of one pose in all views and how far the edges are from them.

    Attributes
    ----------
    cone : (m,) int64
    foot : (m, 3) float64, world
        On the surface, where a view grazes it.
    direction : (m, 3) float64, world
        Unit vector along which the edge is away, across the line of sight.
    distance : (m,) float64, metres
        From the outline to the edge, positive outwards.
    """

    cone: IntArray
    foot: FloatArray
    direction: FloatArray
    distance: FloatArray


def contours_of(
    edges: tuple[EdgeMap, ...], body: BodyModel, frames: PartFrames, farthest: float = FARTHEST
) -> Contours:
    """Measure the outlines of one pose against the edges of all views, within so many metres."""
    table = cone_tables(body.cones, frames)
    measured, limb = _MEASURED[body.cones.part], _LIMB[body.cones.part]
    room = 2 * len(_ALONG) * len(table)
    found = []
    for edge in edges:
        cone, distance = np.empty(room, dtype=np.int64), np.empty(room)
        foot, direction = np.empty((room, 3)), np.empty((room, 3))
        n = measure_outline(
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
            foot,
            direction,
            distance,
            cone,
        )
        kept = np.flatnonzero(np.abs(distance[:n]) < farthest)
        found.append((cone[kept], foot[kept], direction[kept], distance[kept]))
    if not found:
        nowhere = np.empty((0, 3))
        return Contours(np.empty(0, dtype=np.int64), nowhere, nowhere, np.empty(0))
    return Contours(*(np.concatenate(values) for values in zip(*found, strict=True)))


@dataclass(frozen=True, eq=False)
class SilhouetteObservation:
    """The edges of one instant.

    Attributes
    ----------
    edges : tuple of EdgeMap
    sigma : float, metres
        Standard deviation of a contour's distance from its edge.
    effective : float
        Effective sample size of all contours of a frame set.
    """

    edges: tuple[EdgeMap, ...]
    sigma: float
    effective: float = EFFECTIVE

    def residuals(self, body: BodyModel, pose: Pose) -> tuple[SurfaceResidual, ...]:
        """Distances between the outlines of a pose and the edges near them."""
        if not self.edges:
            return ()
        frames = body.frames(pose)
        seen = contours_of(self.edges, body, frames)
        trust = Trust(FARTHEST, _LOSS_SCALE, self.sigma, self.effective)
        feet = ClosestPoints(seen.cone, seen.distance, seen.foot, seen.direction)
        data = seen.foot + seen.distance[:, None] * seen.direction
        return (residual_of_closest(data, parts_of_cones(body, seen.cone), feet, frames, trust),)


@dataclass(frozen=True)
class SilhouetteSensor:
    """Measures outlines where views know the person's, with this standard deviation in metres."""

    sigma: float

    def observe(self, cloud: Cloud) -> SilhouetteObservation:
        """Measure the distances from the edges of one instant."""
        return SilhouetteObservation(edge_maps(cloud), self.sigma)
