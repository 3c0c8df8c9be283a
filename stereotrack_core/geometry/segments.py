"""Distances between line segments."""

from __future__ import annotations

import numpy as np

from stereotrack_core.arrays import FloatArray


def segment_distance(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> FloatArray:
    """Least distances (...) between the segments a to b and c to d, all (..., 3).

    Segments may be points; NaN where one is NaN.
    """
    s, t = nearest_on_segments(a, b, c, d)
    apart = a + s[..., None] * (b - a) - c - t[..., None] * (d - c)
    return np.sqrt(_dot(apart, apart))


def nearest_on_segments(
    a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Shares (...), 0 to 1, from a to b and from c to d where two segments are nearest.

    The nearest points are found on the lines, then moved into the segments one after the other
    (Ericson, Real-Time Collision Detection, section 5.1.9).
    """
    u, v, w = b - a, d - c, a - c
    uu, vv, uv = _dot(u, u), _dot(v, v), _dot(u, v)
    uw, vw = _dot(u, w), _dot(v, w)
    determinant = uu * vv - uv * uv
    crossing = determinant > 1e-12 * uu * vv
    s = np.clip((uv * vw - uw * vv) / np.where(crossing, determinant, np.inf), 0.0, 1.0)
    t = np.clip((uv * s + vw) / np.where(vv > 0, vv, np.inf), 0.0, 1.0)
    s = np.clip((uv * t - uw) / np.where(uu > 0, uu, np.inf), 0.0, 1.0)
    return s, t


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    result: FloatArray = np.einsum("...i,...i->...", a, b)
    return result
