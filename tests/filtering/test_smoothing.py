"""The step backwards against the least squares of all frames at once."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.filtering.smoothing import backward_step
from tests.oracle.kalman import kalman_correction

N, FRAMES = 3, 7


def _symmetric(rng, n, scale=1.0):
    a = rng.normal(size=(n, n))
    return scale * (a @ a.T + 0.2 * np.eye(n))


def _problem(rng, anew_at=None, anew=()):
    """Measurements of a random walk; some numbers are drawn anew in one frame."""
    Q, start = _symmetric(rng, N, 0.3), _symmetric(rng, N, 2.0)
    frames = [
        (rng.normal(size=(2, N)), rng.normal(size=2), rng.uniform(0.1, 1.0, 2))
        for _ in range(FRAMES)
    ]
    carried = np.ones((FRAMES, N), dtype=bool)
    if anew_at is not None:
        carried[anew_at, list(anew)] = False
    return Q, start, frames, carried, 5.0 * np.eye(N)


def _batch(Q, start, frames, carried, wide):
    """Normal equations of all frames: means (F, N) and covariances (F, N, N)."""
    A, b = np.zeros((FRAMES * N, FRAMES * N)), np.zeros(FRAMES * N)
    A[:N, :N] += np.linalg.inv(start)
    for k, (H, z, R) in enumerate(frames):
        own = slice(k * N, (k + 1) * N)
        A[own, own] += H.T @ np.diag(1 / R) @ H
        b[own] += H.T @ (z / R)
        if k:
            kept, lost = np.flatnonzero(carried[k]), np.flatnonzero(~carried[k])
            D = np.zeros((len(kept), FRAMES * N))
            D[np.arange(len(kept)), k * N + kept] = 1
            D[np.arange(len(kept)), (k - 1) * N + kept] = -1
            A += D.T @ np.linalg.inv(Q[np.ix_(kept, kept)]) @ D
            A[k * N + lost, k * N + lost] += 1 / np.diag(wide)[lost]
    P = np.linalg.inv(A)
    blocks = [P[k * N : (k + 1) * N, k * N : (k + 1) * N] for k in range(FRAMES)]
    return (P @ b).reshape(FRAMES, N), np.array(blocks)


def _filtered(Q, start, frames, carried, wide):
    """Filtered means and covariances, and the prior of every frame."""
    x, P, passed = np.zeros(N), start, []
    for k, (H, z, R) in enumerate(frames):
        if k:
            P = P + Q
            lost = ~carried[k]
            x[lost], P[lost], P[:, lost] = 0.0, 0.0, 0.0
            P[lost, lost] = np.diag(wide)[lost]
        prior = (x, P)
        x, P = kalman_correction(x, P, H, z, R)
        passed.append((x.copy(), P.copy(), *prior))
    return passed


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("anew_at", "anew"), [(None, ()), (3, (1,)), (5, (0, 2)), (2, (0, 1, 2))])
def test_going_back_gives_the_least_squares_of_all_frames(seed, anew_at, anew):
    problem = _problem(np.random.default_rng(seed), anew_at, anew)
    means, covariances = _batch(*problem)
    passed, carried = _filtered(*problem), problem[3]
    x, P = passed[-1][:2]
    np.testing.assert_allclose(x, means[-1], atol=1e-9)
    for k in reversed(range(FRAMES - 1)):
        _, _, predicted, P_predicted = passed[k + 1]
        gain, smoothed = backward_step(passed[k][1], P_predicted, carried[k + 1], P)
        x, P = passed[k][0] + gain @ (x - predicted), smoothed
        np.testing.assert_allclose(x, means[k], atol=1e-9)
        np.testing.assert_allclose(P, covariances[k], atol=1e-9)
        np.testing.assert_array_equal(gain[:, ~carried[k + 1]], 0.0)


@given(
    seed=st.integers(0, 2**32 - 1),
    factors=st.lists(st.floats(1.0, 20.0), min_size=N, max_size=N),
    certainty=st.floats(1e-6, 1.0),
    carried=st.lists(st.booleans(), min_size=N, max_size=N),
)
@settings(deadline=None)
def test_the_covariance_never_grows_and_never_becomes_indefinite(seed, factors, certainty, carried):
    rng = np.random.default_rng(seed)
    P = _symmetric(rng, N)
    predicted = (P + _symmetric(rng, N, 0.05)) * np.outer(factors, factors)
    half = np.linalg.cholesky(predicted)
    shrink = np.diag(rng.uniform(0.0, certainty, N))
    after = half @ shrink @ half.T
    _, smoothed = backward_step(P, predicted, np.array(carried), after)
    scale = np.linalg.norm(P)
    assert np.linalg.eigvalsh(P - smoothed).min() > -1e-9 * scale
    assert np.linalg.eigvalsh(smoothed).min() > -1e-9 * scale
    np.testing.assert_array_equal(smoothed, smoothed.T)
