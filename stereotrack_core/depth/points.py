"""From depth images to points in the world, and which of them stay (2.1, 3.1.2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import BoolArray, Float32Array, FloatArray, IntArray
from stereotrack_core.depth.cloud import DepthGeometry
from stereotrack_core.depth.parameters import DepthParameters


@dataclass(frozen=True, eq=False)
class Volume:
    """Working volume: a box along the world's axes.

    Attributes
    ----------
    low, high : (3,) float64, world, metres
    """

    low: FloatArray
    high: FloatArray

    @staticmethod
    def of(p: DepthParameters) -> Volume:
        """The volume that the parameters describe."""
        half = np.array([p.volume_x / 2, p.volume_y / 2])
        centre = np.array([p.volume_centre_x, p.volume_centre_y])
        low = np.array([*(centre - half), p.volume_bottom])
        return Volume(low, np.array([*(centre + half), p.volume_bottom + p.volume_z]))

    def contains(self, points: FloatArray) -> BoolArray:
        """Which of the points (N, 3) are inside, border included."""
        result: BoolArray = np.all((points >= self.low) & (points <= self.high), axis=1)
        return result

    def corners(self) -> FloatArray:
        """The eight corners (8, 3)."""
        grid = np.meshgrid(*np.stack([self.low, self.high], axis=1), indexing="ij")
        corners: FloatArray = np.stack(grid, axis=-1).reshape(8, 3)
        return corners


def range_of_disparity(geometry: DepthGeometry, disparity: Float32Array) -> Float32Array:
    """Range z = f b / (d - offset), equation (2.1); NaN where invalid or not in front."""
    parallax = disparity - np.float32(geometry.disparity_offset)
    with np.errstate(divide="ignore"):
        z = np.float32(geometry.focal * geometry.baseline) / parallax
    z[~(parallax > 0)] = np.nan
    result: Float32Array = z
    return result


def thinned_pixels(chosen: BoolArray, step: int, origin: tuple[int, int]) -> IntArray:
    """Columns and rows (N, 2) of the chosen pixels on every `step`-th row and column.

    The same rows and columns of the image whatever the region is.

    Parameters
    ----------
    chosen : (h, w) bool
    step : int
    origin : (int, int)
        Column and row of the array's first pixel in the view's depth image.
    """
    left, top = ((step // 2 - start) % step for start in origin)
    rows, columns = np.nonzero(chosen[top::step, left::step])
    in_region = np.stack([columns * step + left, rows * step + top], axis=1)
    pixels: IntArray = in_region + np.array(origin)
    return pixels


def world_points(geometry: DepthGeometry, range_z: FloatArray, pixels: IntArray) -> FloatArray:
    """Points (N, 3), world, metres, of pixels with their ranges, (2.2) and (2.3).

    Parameters
    ----------
    geometry : DepthGeometry
    range_z : (N,) float64, metres
    pixels : (N, 2) int64
        Column and row in the view's depth image.
    """
    x = (pixels[:, 0] - geometry.c_x) / geometry.focal * range_z
    y = (pixels[:, 1] - geometry.c_y) / geometry.focal * range_z
    return geometry.world_from_depth.apply(np.stack([x, y, range_z], axis=1))
