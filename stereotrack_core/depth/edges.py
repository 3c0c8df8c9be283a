"""The edge of a person's silhouette in one view, as signed distances around the person."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from stereotrack_core.arrays import BoolArray, Float32Array, FloatArray

_LEAST_PATCH = 150
"""Pixels below which a patch of the silhouette is noise."""

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


def edge_map(
    outline: BoolArray,
    range_z: Float32Array,
    lens: tuple[float, float, float],
    camera_from_world: FloatArray,
) -> EdgeMap | None:
    """Measure the edge of an outline; None if there is no patch of a person's size.

    Parameters
    ----------
    outline : (H, W) bool
    range_z : (H, W) float32, metres
    lens : tuple of float
        Focal length and principal point, pixels.
    camera_from_world : (3, 4) float64
    """
    left, top, width, height = cv2.boundingRect(outline.view(np.uint8))
    patches = outline[top : top + height, left : left + width].astype(np.uint8)
    cv2.filterSpeckles(patches, 0, _LEAST_PATCH - 1, 0)
    column, row, width, height = cv2.boundingRect(patches)
    if not width:
        return None
    person = patches[row : row + height, column : column + width]
    left, top = left + column, top + row
    before, above = min(_AROUND, left), min(_AROUND, top)
    after = min(_AROUND, outline.shape[1] - left - width)
    below = min(_AROUND, outline.shape[0] - top - height)
    left, top = left - before, top - above
    inside = cv2.copyMakeBorder(person, above, below, before, after, cv2.BORDER_CONSTANT)
    outward = cv2.distanceTransform(1 - inside, cv2.DIST_L2, 5)
    inward = cv2.distanceTransform(inside, cv2.DIST_L2, 5)
    # Both count to the middle of a pixel on the other side; the edge runs half a pixel before it.
    distance = outward - inward - (0.5 - inside.astype(np.float32))
    height, width = distance.shape
    return EdgeMap(
        distance=distance.astype(np.float32, copy=False),
        range_z=np.ascontiguousarray(range_z[top : top + height, left : left + width]),
        pinhole=np.array([*lens, left, top], dtype=np.float64),
        camera_from_world=camera_from_world,
    )
