"""Clicks are judged by all but themselves."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from stereotrack_core.annotation.fit.residuals import (
    judged,
)


def fitted_line(pixels, sigma, weight, prior):
    """A landmark at x (2,) seen by V cameras directly: fit, residuals, covariance."""
    trust = weight / sigma**2
    P = np.eye(2) / (1.0 / prior**2 + trust.sum())
    x = P @ (trust @ pixels)
    return pixels - x, np.tile(P, (len(pixels), 1, 1))


@given(st.integers(0, 2**16))
def test_surprise_is_that_of_a_fit_without_the_click(seed):
    rng = np.random.default_rng(seed)
    sigma, weight = rng.uniform(1, 5, 4), rng.uniform(0.2, 1, 4)
    pixels = rng.normal(0, 4, (4, 2))
    residual, spread = fitted_line(pixels, sigma, weight, 50.0)
    found = judged(residual, spread, sigma, weight, 0.03)
    for i in range(4):
        rest = np.delete(np.arange(4), i)
        away, P = fitted_line(pixels[rest], sigma[rest], weight[rest], 50.0)
        alone = pixels[i] - (pixels[rest] - away)[0]
        expected = alone @ np.linalg.solve(P[0] + sigma[i] ** 2 * np.eye(2), alone)
        np.testing.assert_allclose(found.surprise[i], expected, rtol=1e-6)


def test_what_is_far_off_is_an_outlier_and_what_is_near_is_not():
    pixels = np.array([[0.0, 0.5], [1.0, -1.0], [-1.0, 0.0], [40.0, 10.0]])
    sigma, weight = np.full(4, 2.0), np.array([1.0, 1.0, 1.0, 1e-3])
    residual, spread = fitted_line(pixels, sigma, weight, 200.0)
    found = judged(residual, spread, sigma, weight, 0.03)
    assert found.outlier_probability[3] > 0.99
    assert (found.outlier_probability[:3] < 0.05).all()


def test_a_click_that_nothing_else_knows_about_is_not_accused():
    residual, spread = fitted_line(np.array([[30.0, 0.0]]), np.array([2.0]), np.ones(1), 500.0)
    found = judged(residual, spread, np.array([2.0]), np.ones(1), 0.03)
    assert found.outlier_probability[0] < 0.05
    assert found.leverage[0] > 0.99
