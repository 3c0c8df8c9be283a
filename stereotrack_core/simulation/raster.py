"""Triangles into a depth buffer, and what is seen of them at each sample.

Vertices come projected by the true camera (distortion included), so that triangles of a few
pixels give the picture of the distorted lens; every pixel is sampled 2 x 2.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from stereotrack_core.arrays import Float32Array, FloatArray, IntArray
from stereotrack_core.compiled import compiled

SAMPLES = 2  # samples per pixel along each axis


def in_samples(pixels: FloatArray, origin: tuple[int, int] = (0, 0)) -> FloatArray:
    """Coordinates in samples of pixels (V, 2); `origin` is the pixel at the buffers' corner."""
    return np.asarray((pixels - np.asarray(origin) + 0.5) * SAMPLES - 0.5)


@dataclass(frozen=True, eq=False)
class Raster:
    """The nearest surface at each sample; `draw` adds to it."""

    depth: Float32Array  # (h, w); 1 / z of the nearest surface so far
    triangle: IntArray
    """(h, w); number of the triangle seen there, counted over all meshes; -1 without one."""
    weights: Float32Array
    """(h, w, 2); shares of the triangle's second and third corner, corrected for perspective."""

    @staticmethod
    def over(depth: Float32Array) -> Raster:
        """An empty raster that draws only what is nearer than `depth`, which it changes."""
        triangle: Any = np.full(depth.shape, -1, np.int32)
        return Raster(depth, triangle, np.zeros((*depth.shape, 2), np.float32))

    def draw(
        self, samples: FloatArray, nearness: FloatArray, triangles: IntArray, first: int = 0
    ) -> None:
        """Draw a mesh of triangles (T, 3), the first of this number, where it is nearer.

        `samples` (V, 2) as :func:`in_samples` makes them, NaN drops the triangle; `nearness` (V,)
        is 1 / z in the camera.
        """
        buffers = self.depth, self.triangle, self.weights
        _rasterise(buffers, samples, nearness, triangles, first)

    def seen(self, triangles: IntArray, first: int = 0) -> Samples:
        """The samples that show a mesh, once everything is drawn."""
        numbers = self.triangle - first
        where = np.nonzero((numbers >= 0) & (numbers < len(triangles)))
        triangle = numbers[where]
        second, third = self.weights[where].T
        shares = np.stack([1.0 - second.astype(np.float64) - third, second, third])
        return Samples(where, triangle, triangles[triangle], shares)


@dataclass(frozen=True, eq=False)
class Samples:
    """Samples (N) of a raster that show one mesh."""

    where: tuple[Any, ...]  # rows and columns, as an index into pictures
    triangle: IntArray  # (N,)
    corners: IntArray  # (N, 3); vertices of each triangle
    shares: FloatArray  # (3, N); of each corner in what is seen

    def of(self, values: FloatArray) -> FloatArray:
        """Interpolate values (V, C) of the vertices, (N, C)."""
        a, b, c = (s[:, None] * values[k] for s, k in zip(self.shares, self.corners.T, strict=True))
        return np.asarray(a + b + c)


@compiled()
def _rasterise(out_buffers: Any, samples: Any, nearness: Any, triangles: Any, first: int) -> None:
    depth, ids, weights = out_buffers
    height, width = depth.shape
    for t in range(triangles.shape[0]):
        i, j, k = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        ax, ay = samples[i, 0], samples[i, 1]
        bx, by = samples[j, 0], samples[j, 1]
        cx, cy = samples[k, 0], samples[k, 1]
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if not abs(area) > 1e-12:
            continue
        left = max(0, int(min(ax, bx, cx)))
        right = min(width - 1, int(max(ax, bx, cx)) + 1)
        top = max(0, int(min(ay, by, cy)))
        bottom = min(height - 1, int(max(ay, by, cy)) + 1)
        na, nb, nc = nearness[i], nearness[j], nearness[k]
        for y in range(top, bottom + 1):
            for x in range(left, right + 1):
                wb = ((x - ax) * (cy - ay) - (y - ay) * (cx - ax)) / area
                wc = ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / area
                wa = 1.0 - wb - wc
                if wa < -1e-9 or wb < -1e-9 or wc < -1e-9:
                    continue
                near = wa * na + wb * nb + wc * nc
                if near <= depth[y, x]:
                    continue
                depth[y, x] = near
                ids[y, x] = first + t
                weights[y, x, 0] = wb * nb / near
                weights[y, x, 1] = wc * nc / near
