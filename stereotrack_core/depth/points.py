"""From depth images to points in the world, and which of them stay (2.1, 3.1.2)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from stereotrack_core.arrays import BoolArray, Float32Array, FloatArray, IntArray
from stereotrack_core.compiled import compiled
from stereotrack_core.depth.cloud import DepthGeometry
from stereotrack_core.depth.parameters import DepthParameters


@dataclass(frozen=True, eq=False)
class Volume:
    """Working volume: a box along the world's axes."""

    low: FloatArray
    high: FloatArray  # `low` and `high`: (3,), world, metres

    @staticmethod
    def of(p: DepthParameters) -> Volume:
        """The volume that the parameters describe."""
        half = np.array([p.volume_x / 2, p.volume_y / 2])
        centre = np.array([p.volume_centre_x, p.volume_centre_y])
        low = np.array([*(centre - half), p.volume_bottom])
        high = np.array([*(centre + half), p.volume_bottom + p.volume_z])
        ends = np.stack([low, high]) @ p.upright.rotation
        return Volume(ends.min(axis=0), ends.max(axis=0))

    def contains(self, points: FloatArray) -> BoolArray:
        """Which of the points (N, 3) are inside, border included."""
        return np.asarray(np.all((points >= self.low) & (points <= self.high), axis=1))

    def corners(self) -> FloatArray:
        """The eight corners (8, 3)."""
        grid = np.meshgrid(*np.stack([self.low, self.high], axis=1), indexing="ij")
        return np.stack(grid, axis=-1).reshape(8, 3)


def range_of_disparity(geometry: DepthGeometry, disparity: Float32Array) -> Float32Array:
    """Range z = f b / (d - offset), equation (2.1); NaN where invalid or not in front."""
    parallax = disparity - np.float32(geometry.disparity_offset)
    scale = np.float32(geometry.focal * geometry.baseline)
    with np.errstate(divide="ignore"):
        return np.where(parallax > 0, scale / parallax, np.float32(np.nan))


def thinned_pixels(chosen: BoolArray, step: int, origin: tuple[int, int]) -> IntArray:
    """Pixels (N, 2) of a region that begins at `origin`, on every `step`-th row and column."""
    left, top = ((step // 2 - start) % step for start in origin)
    rows, columns = np.nonzero(np.ascontiguousarray(chosen[top::step, left::step]))
    in_region = np.stack([columns * step + left, rows * step + top], axis=1)
    return np.asarray(in_region + np.array(origin))


_MOST_CELLS = 160  # along one axis; a small distance is searched in larger cells


def inliers(points: FloatArray, neighbours: int, distance: float, *, repeat: bool) -> BoolArray:
    """Which points (N, 3) keep all their k nearest neighbours within a distance in metres (3.1.2).

    All points are judged at once, against all others, so that their order does not matter. With
    `repeat` the rest is judged again until nothing changes.

    The k nearest are within the distance exactly if at least k others are. So the search over a
    grid of cells as large as the distance can stop at the k-th: 0.6 ms for 6400 points, a k-d tree
    took 7.
    """
    kept = np.ones(len(points), dtype=bool)
    if not len(points) or neighbours < 1:
        return kept
    low = points.min(axis=0)
    extent = points.max(axis=0) - low
    size = max(distance, float(extent.max()) / _MOST_CELLS) * (1.0 + 1e-9)
    cell = ((points - low) / size).astype(np.int64)
    shape = cell.max(axis=0) + 1
    flat = (cell[:, 0] * shape[1] + cell[:, 1]) * shape[2] + cell[:, 2]
    order = np.argsort(flat, kind="stable")
    starts = np.zeros(int(shape.prod()) + 1, dtype=np.int64)
    np.cumsum(np.bincount(flat, minlength=len(starts) - 1), out=starts[1:])
    grid = cell[order], shape, starts
    ordered = np.ascontiguousarray(points[order])
    kept[order] = _with_neighbours(ordered, grid, neighbours, distance * distance, repeat)
    return kept


@compiled()
def _with_neighbours(
    points: FloatArray, grid: Any, neighbours: int, squared: float, repeat: bool
) -> BoolArray:  # pragma: no cover - compiled
    """Whether each of the points, ordered by cell, has that many others in reach."""
    cell, shape, starts = grid
    kept, changed = np.ones(len(points), dtype=np.bool_), True
    while changed:
        changed = False
        # What is left in the end does not depend on the order in which points are dropped.
        others = kept if repeat else kept.copy()
        for i in range(len(points)):
            if not kept[i]:
                continue
            found = -1  # the point itself is met as well
            x0, x1 = max(cell[i, 0] - 1, 0), min(cell[i, 0] + 1, shape[0] - 1)
            y0, y1 = max(cell[i, 1] - 1, 0), min(cell[i, 1] + 1, shape[1] - 1)
            z0, z1 = max(cell[i, 2] - 1, 0), min(cell[i, 2] + 1, shape[2] - 1)
            for x in range(x0, x1 + 1):
                for y in range(y0, y1 + 1):
                    row = (x * shape[1] + y) * shape[2]
                    # Cells that follow each other along z follow each other in memory.
                    for j in range(starts[row + z0], starts[row + z1 + 1]):
                        dx = points[i, 0] - points[j, 0]
                        dy = points[i, 1] - points[j, 1]
                        dz = points[i, 2] - points[j, 2]
                        if others[j] and dx * dx + dy * dy + dz * dz <= squared:
                            found += 1
                            if found >= neighbours:
                                break
                    if found >= neighbours:
                        break
                if found >= neighbours:
                    break
            if found < neighbours:
                kept[i], changed = False, repeat
    return kept
