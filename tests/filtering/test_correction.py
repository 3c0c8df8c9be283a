"""The correction that touches m once, against dense forms and other programs."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.filtering.correction import correct
from stereotrack_core.filtering.sigma_points import scaled_weights, sigma_deviations
from tests.filtering.cases import covariance, curved
from tests.oracle.kalman import dense_correction, kalman_correction

N = 14


def _problem(rng, weights, m, curvature=0.4, n=N):
    """P, dX, dY, nu, R of a curved function with sigmas as a tracker has them."""
    P = covariance(rng, n, 0.05)
    dX = sigma_deviations(P, weights)
    h = curved(rng, n, m, curvature)
    Y = np.array([h(d) for d in dX])
    dY = Y - weights.mean @ Y
    return P, dX, dY, rng.normal(size=m) * 0.1, rng.uniform(0.1, 0.3, m) ** 2


@pytest.mark.parametrize("m", [1, 64, 1024])
@pytest.mark.parametrize(
    ("spread", "curvature", "tolerance", "middle"),
    [
        ((0.1, 2.0, 0.0), 0.4, 1e-11, -96.01),
        ((0.001, 2.0, 0.0), 0.05, 1e-9, -999996.000001),
        # The middle point's weight of a million cancels the others' almost completely.
        ((0.001, 2.0, 0.0), 0.4, 1e-6, -999996.000001),
        ((1.0, 0.0, 0.0), 0.4, 1e-9, 0.0),
        ((1.0, 0.0, -3.0), 0.4, 1e-9, -3.0 / 11.0),
        ((1.0, 2.0, 2.0), 0.4, 1e-9, 2.0 / 16.0 + 2.0),
    ],
)
def test_it_equals_the_dense_correction(rng, spread, curvature, tolerance, middle, m):
    weights = scaled_weights(N, *spread)
    assert weights.covariance[0] == pytest.approx(middle, rel=1e-9, abs=1e-12)
    P, dX, dY, nu, R = _problem(rng, weights, m, curvature)
    dx, after = dense_correction(P, dX, dY, weights.covariance, nu, R)
    found_dx, found_P = correct(P, dX, dY, weights.covariance, nu, R)
    np.testing.assert_allclose(found_dx, dx, rtol=0, atol=tolerance * max(1, abs(dx).max()))
    np.testing.assert_allclose(found_P, after, rtol=0, atol=tolerance * max(1, abs(after).max()))


@settings(max_examples=50, deadline=None)
@given(
    n=st.integers(1, 16),
    m=st.integers(1, 60),
    alpha=st.floats(0.01, 1.0),
    noise=st.floats(1e-3, 10.0),
    seed=st.integers(0, 2**32 - 1),
)
def test_a_linear_measurement_gives_the_kalman_filter(n, m, alpha, noise, seed):
    rng = np.random.default_rng(seed)
    x, P, H = rng.normal(size=n), covariance(rng, n), rng.normal(size=(m, n))
    z, R = rng.normal(size=m), np.full(m, noise**2)
    weights = scaled_weights(n, alpha, 2.0, 0.0)
    dX = sigma_deviations(P, weights)
    corrected_dx, corrected_P = correct(P, dX, dX @ H.T, weights.covariance, z - H @ x, R)
    mean, after = kalman_correction(x, P, H, z, R)
    np.testing.assert_allclose(x + corrected_dx, mean, atol=1e-6)
    np.testing.assert_allclose(corrected_P, after, atol=1e-6)
    np.testing.assert_array_equal(corrected_P, corrected_P.T)
    assert np.linalg.eigvalsh(P - corrected_P).min() > -1e-6
