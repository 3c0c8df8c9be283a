"""From depth images to points in the world, and which of them stay (2.1, 3.1.2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

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


def world_points(
    geometry: DepthGeometry, range_z: Float32Array, chosen: BoolArray, step: int
) -> tuple[FloatArray, IntArray]:
    """Points of the chosen pixels on every `step`-th row and column, (2.2) and (2.3).

    Returns
    -------
    points : (N, 3) float64, world, metres
    pixels : (N, 2) int64
        Column and row.
    """
    first = step // 2
    rows, columns = np.nonzero(chosen[first::step, first::step])
    rows, columns = rows * step + first, columns * step + first
    z = range_z[rows, columns].astype(np.float64)
    x = (columns - geometry.c_x) / geometry.focal * z
    y = (rows - geometry.c_y) / geometry.focal * z
    points = geometry.world_from_depth.apply(np.stack([x, y, z], axis=1))
    return points, np.stack([columns, rows], axis=1)


def inliers(points: FloatArray, neighbours: int, distance: float, *, repeat: bool) -> BoolArray:
    """Which points keep all their k nearest neighbours within a distance (3.1.2).

    All points are judged at once, against all points, so that their order does not matter;
    a point is not its own neighbour. With `repeat` what is left is judged again until nothing
    changes.

    Parameters
    ----------
    points : (N, 3) float64
    neighbours : int
        k; with 0 all points stay.
    distance : float
        Metres.
    """
    kept = np.ones(len(points), dtype=bool)
    while neighbours > 0:
        index = np.flatnonzero(kept)
        stays = _have_neighbours(points[index], neighbours, distance)
        kept[index[~stays]] = False
        if not repeat or stays.all():
            break
    return kept


def _have_neighbours(points: FloatArray, neighbours: int, distance: float) -> BoolArray:
    if len(points) <= neighbours:
        return np.zeros(len(points), dtype=bool)
    tree = KDTree(points, balanced_tree=False, compact_nodes=False)
    # The k-th neighbour besides the point itself, which is its own first one. The bound is
    # exclusive in scipy.
    bound = np.nextafter(distance, np.inf)
    farthest, _ = tree.query(points, k=[neighbours + 1], distance_upper_bound=bound)
    result: BoolArray = np.isfinite(farthest[:, 0])
    return result
