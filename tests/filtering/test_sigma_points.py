"""The scaled unscented transform against sums written out."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.filtering.sigma_points import scaled_weights, sigma_deviations
from tests.filtering.cases import covariance
from tests.oracle import unscented


@pytest.mark.parametrize(
    ("alpha", "beta", "kappa"), [(0.1, 2.0, 0.0), (0.001, 2.0, 0.0), (1.0, 0.0, 0.0), (1, 2, -11)]
)
def test_points_and_weights_are_those_of_the_literature(rng, alpha, beta, kappa):
    n = 14
    x, P = rng.normal(size=n), covariance(rng, n)
    points, means, covariances = unscented.sigma_points(x, P, alpha, beta, kappa)
    weights = scaled_weights(n, alpha, beta, kappa)
    np.testing.assert_allclose(weights.mean, means, rtol=1e-9)
    np.testing.assert_allclose(weights.covariance, covariances, rtol=1e-9)
    np.testing.assert_allclose(x + sigma_deviations(P, weights), points, atol=1e-12)


@settings(max_examples=40, deadline=None)
@given(
    n=st.integers(1, 20),
    alpha=st.floats(0.01, 1.5),
    kappa=st.floats(0.0, 5.0),
    seed=st.integers(0, 2**32 - 1),
)
def test_the_points_have_the_mean_and_the_covariance_they_stand_for(n, alpha, kappa, seed):
    P = covariance(np.random.default_rng(seed), n)
    weights = scaled_weights(n, alpha, 2.0, kappa)
    dX = sigma_deviations(P, weights)
    assert weights.mean.sum() == pytest.approx(1.0, abs=1e-9)
    np.testing.assert_allclose(weights.mean @ dX, 0.0, atol=1e-9)
    np.testing.assert_allclose((dX.T * weights.covariance) @ dX, P, atol=1e-9 * abs(P).max())


def test_a_covariance_that_is_none_is_refused():
    with pytest.raises(np.linalg.LinAlgError):
        sigma_deviations(np.diag([1.0, -1.0]), scaled_weights(2, 0.1, 2.0, 0.0))
