"""Disparities to a small part of a pixel, by least squares on the grey values themselves.

A block matcher's parabola is drawn to whole pixels, and its window takes in what lies beside a thin
limb. Here both pictures are aligned around each pixel, with the person's own pixels only: Lucas and
Kanade's method with gain and offset (doi:10.1023/B:VISI.0000011205.11775.fd).
"""

import math
from typing import Any

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, ImageArray, IntArray
from stereotrack_core.compiled import compiled

_ITERATIONS = 6
_ENOUGH = 0.02  # pixels; a smaller step ends the iteration
_FARTHEST = 1.0  # pixels from the matcher's disparity; beyond, something else was found
_GREY = 15.0  # grey levels of a difference that loses half of its weight
_LEAST_WEIGHT = 6.0  # sum of weights below which too little of the person is around a pixel
_ONE, _TWO = np.uint64(1), np.uint64(2)  # steps of unsigned indices
_GAIN_SIGMA = 0.1  # spread of the gain in a pair, against grey levels' noise of one


def refined_disparity(
    left: ImageArray,
    right: ImageArray,
    person: BoolArray,
    pixels: IntArray,
    disparity: FloatArray,
    window: int,
) -> FloatArray:
    """Align both rectified pictures (H, W) around some pixels (N, 2) of the right one.

    Returns disparities (N,), pixels; the matcher's own `disparity`, also NaN, where the pictures
    cannot be aligned. `person` (H, W) are the right picture's pixels that may be looked at,
    `window` is the side of the neighbourhood, pixels (odd).
    """
    result = np.asarray(disparity, dtype=np.float64).copy()
    half = window // 2
    steps = np.arange(-half, half + 1)
    near = np.exp(-(steps[:, None] ** 2 + steps**2) / (0.5 * max(half, 1) ** 2))
    grey = np.ascontiguousarray(left, dtype=np.float32), np.ascontiguousarray(right)
    _align(*grey, np.ascontiguousarray(person), pixels, near.astype(np.float32), result)
    return result


@compiled()
def _align(left: Any, right: Any, person: Any, pixels: Any, near: Any, disparity: Any) -> None:
    """Refine all disparities (N,) in place."""
    for i in range(len(pixels)):
        start = disparity[i]
        if not math.isfinite(start):
            continue  # as a column it would lead out of the image, and end the process
        d, gain, offset = start, 1.0, 0.0
        found = False
        for k in range(_ITERATIONS):
            place = (pixels[i, 0], pixels[i, 1], d, gain, offset)
            sums = _gather(left, right, person, place, k > 0, near)
            if sums[5] < _LEAST_WEIGHT:
                found = False
                break
            found, step, more, further = _solved(sums, gain)
            if not found:
                break
            d, gain, offset = d + min(0.5, max(-0.5, step)), gain + more, offset + further
            if abs(step) < _ENOUGH:
                break
        if found and abs(d - start) <= _FARTHEST:
            disparity[i] = d


@compiled()
def _gather(left: Any, right: Any, person: Any, place: Any, robust: bool, near: Any) -> Any:
    """Sums (9,) of the normal equations of step, gain and offset; the weights are the sixth."""
    column, row, d, gain, offset = place
    height, width = right.shape
    half = near.shape[0] // 2
    whole = math.floor(d)
    # Interpolated linearly: a cubic takes away a bias of up to 0.04 px, but lets through the
    # noise of the grey values, which costs more.
    f = np.float32(d - whole)
    g = np.float32(1.0) - f
    ss = sg = s1 = gg = g1 = total = sr = gr = r1 = 0.0
    first = max(-half, -column, 1 - whole - column)
    last = min(half, width - 1 - column, width - 3 - whole - column)
    for dv in range(max(-half, -row), min(half, height - 1 - row) + 1):
        for du in range(first, last + 1):
            # Unsigned indices need no check for negative ones, which takes a fifth of the time.
            v, u, x = np.uint64(row + dv), np.uint64(column + du), np.uint64(column + du + whole)
            if not person[v, u]:
                continue
            a, b = left[v, x], left[v, x + _ONE]
            slope = np.float32(0.5) * (g * (b - left[v, x - _ONE]) + f * (left[v, x + _TWO] - a))
            grey = float(right[v, u])
            r = (g * a + f * b) - (gain * grey + offset)
            w = near[np.uint64(dv + half), np.uint64(du + half)]
            if robust:
                w /= 1.0 + (r / _GREY) * (r / _GREY)
            ws, wg = w * slope, w * grey
            ss += ws * slope
            sg += ws * grey
            s1 += ws
            gg += wg * grey
            g1 += wg
            total += w
            sr += ws * r
            gr += wg * r
            r1 += w * r
    return ss, sg, s1, gg, g1, total, sr, gr, r1


@compiled()
def _solved(sums: Any, gain: float) -> Any:
    """Whether there is a solution, and the step and the changes of gain and offset."""
    # Model: left = gain right + offset - slope step, so J = (slope, -right, -1) times the rest.
    ss, sg, s1, gg, g1, w, sr, gr, r1 = sums
    held = w / (_GAIN_SIGMA * _GAIN_SIGMA)
    gg, gr = gg + held, gr - held * (gain - 1.0)
    # The offset is eliminated, then the gain.
    ss, sg, sr = ss - s1 * s1 / w, sg - s1 * g1 / w, sr - s1 * r1 / w
    gg, gr = gg - g1 * g1 / w, gr - g1 * r1 / w
    determinant = ss * gg - sg * sg
    if not determinant > 1e-3 * ss * gg or not ss > w:
        return False, 0.0, 0.0, 0.0
    step = -(sr * gg - sg * gr) / determinant
    more = (gr + sg * step) / gg
    further = (r1 + s1 * step - g1 * more) / w
    return True, step, more, further
