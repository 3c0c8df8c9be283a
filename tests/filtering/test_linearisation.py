"""Statistical linearisation and iterated posteriors against the textbook's formulas."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar

from stereotrack_core.filtering.linearisation import (
    Information,
    information,
    linearised,
    posterior,
    unwhitened,
)
from stereotrack_core.filtering.sigma_points import scaled_weights, sigma_deviations
from tests.filtering.cases import covariance, curved
from tests.oracle import unscented
from tests.oracle.kalman import kalman_correction


def _linearised_at(h, x, P, alpha, beta=2.0):
    weights = scaled_weights(len(x), alpha, beta, 0.0)
    Y = np.array([np.atleast_1d(h(x + d)) for d in sigma_deviations(P, weights)])
    return linearised(Y, weights)


@pytest.mark.parametrize("alpha", [0.1, 0.7, 1.0])
def test_jacobian_mean_and_error_are_those_of_statistical_regression(rng, alpha):
    n, m = 8, 5
    x, P, h = rng.normal(size=n), covariance(rng, n, 0.3), curved(rng, n, m)
    line = _linearised_at(h, x, P, alpha)
    mean, P_zz, P_xz = unscented.transformed(h, x, P, alpha, 2.0, 0.0)
    H = (np.linalg.inv(P) @ P_xz).T
    L = np.linalg.cholesky(P)
    np.testing.assert_allclose(line.mean, mean, atol=1e-10)
    np.testing.assert_allclose(line.D.T @ np.linalg.inv(L), H, atol=1e-9)
    error = np.diag(P_zz - H @ P @ H.T)
    assert error.max() > 1e-6
    np.testing.assert_allclose(line.spread, np.maximum(error, 0.0), atol=1e-9)


def test_a_linear_function_has_no_error_of_linearisation(rng):
    n, m = 7, 9
    H, P = rng.normal(size=(m, n)), covariance(rng, n)
    line = _linearised_at(lambda x: H @ x, rng.normal(size=n), P, 0.1)
    np.testing.assert_allclose(line.spread, 0.0, atol=1e-9)
    np.testing.assert_allclose(line.D.T, H @ np.linalg.cholesky(P), atol=1e-10)


def test_information_is_gathered_in_whitened_and_stated_in_plain_coordinates(rng):
    n, m = 6, 30
    P, H = covariance(rng, n), rng.normal(size=(m, n))
    nu, R = rng.normal(size=m), rng.uniform(0.1, 2.0, m)
    L = np.linalg.cholesky(P)
    found = unwhitened(information((H @ L).T, nu, R), L)
    np.testing.assert_allclose(found.A, H.T @ np.diag(1 / R) @ H, atol=1e-9)
    np.testing.assert_allclose(found.b, H.T @ np.diag(1 / R) @ nu, atol=1e-9)
    np.testing.assert_array_equal(found.A, found.A.T)


def test_information_of_independent_measurements_adds_up(rng):
    D, nu, R = rng.normal(size=(4, 20)), rng.normal(size=20), rng.uniform(0.1, 2.0, 20)
    total = Information(np.zeros((4, 4)), np.zeros(4))
    for part in (slice(0, 7), slice(7, 20)):
        total += information(D[:, part], nu[part], R[part])
    together = information(D, nu, R)
    np.testing.assert_allclose(total.A, together.A, atol=1e-12)
    np.testing.assert_allclose(total.b, together.b, atol=1e-12)


@settings(max_examples=50, deadline=None)
@given(n=st.integers(1, 14), m=st.integers(1, 50), seed=st.integers(0, 2**32 - 1))
def test_one_linear_step_is_the_kalman_filter_wherever_it_is_linearised(n, m, seed):
    rng = np.random.default_rng(seed)
    P, H = covariance(rng, n), rng.normal(size=(m, n))
    x0, z, R = rng.normal(size=n), rng.normal(size=m), rng.uniform(0.1, 2.0, m)
    at = x0 + rng.normal(size=n)
    P_at = covariance(rng, n)  # linearised with another spread than the prior's
    L = np.linalg.cholesky(P_at)
    found = unwhitened(information((H @ L).T, z - H @ at, R), L)
    dx, after = posterior(np.linalg.inv(P), x0 - at, found)
    mean, covariance_after = kalman_correction(x0, P, H, z, R)
    np.testing.assert_allclose(at + dx, mean, atol=1e-7)
    np.testing.assert_allclose(after, covariance_after, atol=1e-7)


def _iterated(h, z, R, x0, P0, *, from_posterior, rounds=30, alpha=1.0):
    """Means of successive iterations for one number seen through h."""
    x, P, means = np.array([x0]), np.array([[P0]]), []
    for _ in range(rounds):
        line = _linearised_at(h, x, P if from_posterior else np.array([[P0]]), alpha, beta=2.0)
        L = np.sqrt(P if from_posterior else np.array([[P0]]))
        noise = R + line.spread if from_posterior else np.array([R])
        found = unwhitened(information(line.D, z - line.mean, noise), L)
        dx, P = posterior(np.array([[1.0 / P0]]), x0 - x, found)
        x = x + dx
        means.append(float(x[0]))
    return np.array(means)


@pytest.mark.parametrize(("x0", "z"), [(0.8, -0.3), (1.2, 0.1), (-1.0, 0.5)])
def test_iterating_from_the_posterior_finds_the_most_probable_state_from_the_prior_not(x0, z):
    sigma, P0 = 0.01, 16.0
    best = minimize_scalar(
        lambda x: (x - x0) ** 2 / P0 + (z - np.arctan(x)) ** 2 / sigma**2,
        bounds=(-3.0, 3.0),
        method="bounded",
        options={"xatol": 1e-12},
    ).x
    means = _iterated(np.arctan, z, sigma**2, x0, P0, from_posterior=True)
    assert means[-1] == pytest.approx(best, abs=2e-4)
    assert abs(means[-1] - means[-2]) < 1e-9
    from_prior = _iterated(np.arctan, z, sigma**2, x0, P0, from_posterior=False)
    assert abs(from_prior[-1] - best) > 1.0
