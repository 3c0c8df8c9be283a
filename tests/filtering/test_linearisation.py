"""Gathered information and iterated posteriors against the textbook's formulas."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar

from stereotrack_core.filtering.linearisation import information, posterior
from tests.filtering.cases import covariance
from tests.oracle.kalman import kalman_correction


@settings(max_examples=50, deadline=None)
@given(n=st.integers(1, 14), m=st.integers(1, 50), seed=st.integers(0, 2**32 - 1))
def test_one_linear_step_is_the_kalman_filter_wherever_it_is_linearised(n, m, seed):
    rng = np.random.default_rng(seed)
    P, H = covariance(rng, n), rng.normal(size=(m, n))
    x0, z, R = rng.normal(size=n), rng.normal(size=m), rng.uniform(0.1, 2.0, m)
    at = x0 + rng.normal(size=n)
    found = information(H.T, z - H @ at, R)
    dx, after = posterior(np.linalg.inv(P), x0 - at, found)
    mean, covariance_after = kalman_correction(x0, P, H, z, R)
    np.testing.assert_allclose(at + dx, mean, atol=1e-7)
    np.testing.assert_allclose(after, covariance_after, atol=1e-7)


@pytest.mark.parametrize(("x0", "z"), [(0.8, -0.3), (1.2, 0.1), (-1.0, 0.5)])
def test_iterating_from_the_posterior_finds_the_most_probable_state(x0, z):
    sigma, P0, x = 0.01, 16.0, x0
    best = minimize_scalar(
        lambda x: (x - x0) ** 2 / P0 + (z - np.arctan(x)) ** 2 / sigma**2,
        bounds=(-3.0, 3.0),
        method="bounded",
        options={"xatol": 1e-12},
    ).x
    for _ in range(10):
        slope = np.array([[1.0 / (1.0 + x**2)]])
        found = information(slope, np.array([z - np.arctan(x)]), np.array([sigma**2]))
        dx, _ = posterior(np.array([[1.0 / P0]]), np.array([x0 - x]), found)
        x += float(dx[0])
    assert x == pytest.approx(best, abs=1e-5)
