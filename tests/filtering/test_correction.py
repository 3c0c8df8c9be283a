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


def _assert_same(corrected, dx, P, tolerance):
    np.testing.assert_allclose(corrected.dx, dx, rtol=0, atol=tolerance * max(1, abs(dx).max()))
    np.testing.assert_allclose(corrected.P, P, rtol=0, atol=tolerance * max(1, abs(P).max()))


@pytest.mark.parametrize("m", [1, 64, 1024])
@pytest.mark.parametrize(
    ("alpha", "curvature", "tolerance"),
    [
        (0.1, 0.4, 1e-11),
        (0.001, 0.05, 1e-9),
        # The middle point's weight of a million cancels the others' almost completely.
        (0.001, 0.4, 1e-6),
    ],
)
def test_it_equals_the_dense_correction(rng, alpha, curvature, tolerance, m):
    weights = scaled_weights(N, alpha, 2.0, 0.0)
    assert weights.covariance[0] < 0
    P, dX, dY, nu, R = _problem(rng, weights, m, curvature)
    dense = dense_correction(P, dX, dY, weights.covariance, nu, R)
    _assert_same(correct(P, dX, dY, weights.covariance, nu, R), *dense, tolerance)


@pytest.mark.parametrize(
    ("alpha", "beta", "kappa", "middle"),
    [(1.0, 0.0, 0.0, 0.0), (1.0, 0.0, -3.0, -3.0 / 11.0), (1.0, 2.0, 2.0, 2.0 / 16.0 + 2.0)],
)
@pytest.mark.parametrize("m", [1, 64, 1024])
def test_a_middle_weight_of_any_sign_is_right(rng, alpha, beta, kappa, middle, m):
    weights = scaled_weights(N, alpha, beta, kappa)
    assert weights.covariance[0] == pytest.approx(middle, abs=1e-12)
    P, dX, dY, nu, R = _problem(rng, weights, m)
    dense = dense_correction(P, dX, dY, weights.covariance, nu, R)
    _assert_same(correct(P, dX, dY, weights.covariance, nu, R), *dense, 1e-9)


@pytest.mark.parametrize("m", [1, 12, 64])
def test_filterpy_gives_the_same(rng, m):
    kalman = pytest.importorskip("filterpy.kalman")
    alpha, x, P = 0.1, rng.normal(size=N), covariance(rng, N, 0.05)
    h, z = curved(rng, N, m), rng.normal(size=m)
    R = rng.uniform(0.1, 0.3, m) ** 2
    points = kalman.MerweScaledSigmaPoints(N, alpha, 2.0, 0.0)
    theirs = kalman.UnscentedKalmanFilter(N, m, 1.0, hx=h, fx=lambda s, dt: s, points=points)
    theirs.x, theirs.P, theirs.R, theirs.Q = x.copy(), P.copy(), np.diag(R), 0.0 * P
    theirs.predict()
    theirs.update(z)

    weights = scaled_weights(N, alpha, 2.0, 0.0)
    dX = sigma_deviations(P, weights)
    Y = np.array([h(x + d) for d in dX])
    z_hat = weights.mean @ Y
    ours = correct(P, dX, Y - z_hat, weights.covariance, z - z_hat, R)
    np.testing.assert_allclose(x + ours.dx, theirs.x, atol=1e-9)
    np.testing.assert_allclose(ours.P, theirs.P, atol=1e-9)


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
    corrected = correct(P, dX, dX @ H.T, weights.covariance, z - H @ x, R)
    mean, after = kalman_correction(x, P, H, z, R)
    np.testing.assert_allclose(x + corrected.dx, mean, atol=1e-6)
    np.testing.assert_allclose(corrected.P, after, atol=1e-6)
    np.testing.assert_array_equal(corrected.P, corrected.P.T)
    assert np.linalg.eigvalsh(P - corrected.P).min() > -1e-6
