"""Disparities of a fraction of a pixel, against least squares in plain NumPy, pixel by pixel."""

import numpy as np
import pytest

from stereotrack_core.depth.subpixel import refined_disparity
from tests.depth.test_match import SHAPE, exact_pair


def _refined(left, right, given, pixel, start):
    """Align both images around one pixel of the right one; `start` where that fails."""
    (column, row), (person, window) = pixel, given
    half = window // 2
    dv, du = (g.ravel() for g in np.mgrid[-half : half + 1, -half : half + 1])
    v, u = row + dv, column + du
    d, gain, offset, steps = start, 1.0, 0.0, 0
    while steps < 6:
        whole = int(np.floor(d))
        kept = (v >= 0) & (v < SHAPE[0]) & (u >= 0) & (u < SHAPE[1])
        kept &= (u + whole >= 1) & (u + whole <= SHAPE[1] - 3)
        kept[kept] = person[v[kept], u[kept]]
        near = np.exp(-(du[kept] ** 2 + dv[kept] ** 2) / (0.5 * half**2))
        grey = right[v[kept], u[kept]].astype(float)
        rows = left[v[kept]].astype(float)
        place = np.arange(len(rows)), u[kept] + whole

        def at(by, rows=rows, place=place, f=d - whole):
            return (1.0 - f) * rows[place[0], place[1] + by] + f * rows[place[0], place[1] + by + 1]

        slope, r = 0.5 * (at(1) - at(-1)), at(0) - gain * grey - offset
        w = near / (1.0 + (r / 15.0) ** 2) if steps else near
        if w.sum() < 6.0:
            return start
        J = np.stack([slope, -grey, -np.ones(len(grey))], axis=1)
        A, b = J.T @ (w[:, None] * J), -J.T @ (w * r)
        A[1, 1] += w.sum() / 0.1**2
        b[1] -= w.sum() / 0.1**2 * (gain - 1.0)
        B = A[:2, :2] - np.outer(A[:2, 2], A[2, :2]) / A[2, 2]
        if np.linalg.det(B) <= 1e-3 * B[0, 0] * B[1, 1] or B[0, 0] <= w.sum():
            return start
        step, more, further = np.linalg.solve(A, b)
        d, gain, offset = d + np.clip(step, -0.5, 0.5), gain + more, offset + further
        steps += 1
        if abs(step) < 0.02:
            break
    return d if abs(d - start) <= 1.0 else start


@pytest.mark.parametrize(("seed", "shift", "window"), [(0, 6.3, 7), (1, -5.6, 7), (2, 9.45, 9)])
def test_pictures_are_aligned_by_weighted_least_squares(seed, shift, window, rng):
    left, right = (one.astype(float) for one in exact_pair(shift, seed))
    contrast = np.geomspace(0.02, 1.0, SHAPE[0])[:, None]
    left = np.rint(20.0 + 1.1 * (127 + contrast * (left - 127))).clip(0, 255).astype(np.uint8)
    right = (127 + contrast * (right - 127)) * np.linspace(0.9, 1.1, SHAPE[1])
    right = np.rint(right + rng.normal(0.0, 1.0, SHAPE)).clip(0, 255).astype(np.uint8)
    person = rng.random(SHAPE) < np.linspace(0.2, 1.0, SHAPE[1])
    pixels = np.stack([rng.integers(0, n, 250) for n in SHAPE[::-1]], axis=1)
    start = shift + rng.uniform(-1.3, 1.3, len(pixels))
    found = refined_disparity(left, right, person, pixels, start, window)
    given = person, window
    pairs = zip(pixels, start, strict=True)
    expected = [_refined(left, right, given, pixel, d) for pixel, d in pairs]
    assert 50 < np.count_nonzero(expected != start) < 220
    np.testing.assert_allclose(found, expected, atol=2e-4)
