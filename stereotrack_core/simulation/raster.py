"""A small rasteriser: triangles into a depth buffer, with the coordinates of what is seen.

Vertices come projected by the true camera (distortion included), so that triangles of a few
pixels give the picture of the distorted lens; every pixel is sampled 2 x 2.
"""

from __future__ import annotations

from typing import Any

from stereotrack_core.simulation.compiled import compiled

SAMPLES = 2
"""Samples per pixel along each axis."""


@compiled
def rasterise(
    pixels: Any,
    nearness: Any,
    triangles: Any,
    first_id: int,
    origin_x: int,
    origin_y: int,
    depth: Any,
    ids: Any,
    weights: Any,
) -> None:
    """Draw triangles where they are nearer than what is there.

    Parameters
    ----------
    pixels : (V, 2) float64
        Pixel coordinates of the whole image; NaN drops the triangle.
    nearness : (V,) float64
        1 / z in the camera.
    triangles : (T, 3) int64
    first_id : int
        Number of the first triangle in `ids`.
    origin_x, origin_y : int
        Pixel of the whole image at the corner of the buffers.
    depth : (h, w) float32
        1 / z of the nearest surface so far, per sample.
    ids : (h, w) int32
        Number of the triangle seen there.
    weights : (h, w, 2) float32
        Shares of the second and third corner, corrected for perspective.
    """
    height, width = depth.shape
    for t in range(triangles.shape[0]):
        i, j, k = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        ax, ay = _sample(pixels[i, 0], origin_x), _sample(pixels[i, 1], origin_y)
        bx, by = _sample(pixels[j, 0], origin_x), _sample(pixels[j, 1], origin_y)
        cx, cy = _sample(pixels[k, 0], origin_x), _sample(pixels[k, 1], origin_y)
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
                ids[y, x] = first_id + t
                weights[y, x, 0] = wb * nb / near
                weights[y, x, 1] = wc * nc / near


@compiled
def _sample(pixel: float, origin: int) -> float:
    """Coordinate in samples of a pixel coordinate; sample centres are whole numbers."""
    return (pixel - origin + 0.5) * SAMPLES - 0.5
