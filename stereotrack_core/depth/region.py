"""The part of an image that has to be looked at."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from stereotrack_core.arrays import FloatArray, ImageArray
from stereotrack_core.depth.cloud import DepthGeometry

_SHRINK = 4
_CHANGE = 8.0  # grey levels, over 4 x 4 pixels; sensor noise leaves about one
_LARGEST_SHARE = 0.8


@dataclass(frozen=True)
class Region:
    """Columns ``left`` to ``right`` and rows ``top`` to ``bottom``, half-open."""

    left: int
    top: int
    right: int
    bottom: int

    @staticmethod
    def whole(width: int, height: int) -> Region:
        """A whole image."""
        return Region(0, 0, width, height)

    @property
    def slices(self) -> tuple[slice, slice]:
        """Index of the region in an image."""
        return slice(self.top, self.bottom), slice(self.left, self.right)

    @property
    def is_empty(self) -> bool:
        """Whether there is no pixel inside."""
        return self.left >= self.right or self.top >= self.bottom

    def grown(self, margin: int) -> Region:
        """The region with a margin on all sides; may reach beyond the image."""
        return Region(
            self.left - margin, self.top - margin, self.right + margin, self.bottom + margin
        )

    def __and__(self, other: Region) -> Region:
        return Region(
            max(self.left, other.left),
            max(self.top, other.top),
            min(self.right, other.right),
            min(self.bottom, other.bottom),
        )


def region_of_points(geometry: DepthGeometry, corners_world: FloatArray) -> Region:
    """Where a convex body with these corners can appear; the whole image if it is too near."""
    whole = Region.whole(geometry.width, geometry.height)
    x, y, z = geometry.world_from_depth.inverse().apply(corners_world).T
    if z.min() < 0.1:
        return whole
    u = geometry.focal * x / z + geometry.c_x
    v = geometry.focal * y / z + geometry.c_y
    seen = Region(
        int(np.floor(u.min())), int(np.floor(v.min())), int(u.max()) + 2, int(v.max()) + 2
    )
    return seen & whole


def changed_region(image: ImageArray, empty: ImageArray, margin: int) -> Region:
    """Bounding box of what differs from the picture of the empty scene.

    A common change of brightness does not count. Where nearly everything has changed, or
    nothing, the whole image is returned: then the comparison proves nothing.

    Parameters
    ----------
    image, empty : (H, W) uint8
        Rectified grey images.
    margin : int
        Pixels around the box.
    """
    height, width = image.shape
    whole = Region.whole(width, height)
    small = (width // _SHRINK, height // _SHRINK)
    now = cv2.resize(image, small, interpolation=cv2.INTER_AREA).astype(np.float32)
    before = cv2.resize(empty, small, interpolation=cv2.INTER_AREA).astype(np.float32)
    gain = float(np.median((now[::2, ::2] + 1) / (before[::2, ::2] + 1)))
    changed = np.abs(now - gain * before) > _CHANGE
    columns, rows = np.flatnonzero(changed.any(axis=0)), np.flatnonzero(changed.any(axis=1))
    if len(columns) == 0 or changed.mean() > _LARGEST_SHARE:
        return whole
    box = Region(
        int(columns[0]) * _SHRINK,
        int(rows[0]) * _SHRINK,
        (int(columns[-1]) + 2) * _SHRINK,
        (int(rows[-1]) + 2) * _SHRINK,
    )
    return box.grown(margin) & whole
