"""Distances from the edges of the silhouettes, once per frame."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from stereotrack_core.arrays import BoolArray, Float32Array, FloatArray
from stereotrack_core.depth.cloud import Cloud

_LEAST_PATCH = 150
"""Pixels below which a patch of the silhouette is noise."""

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
