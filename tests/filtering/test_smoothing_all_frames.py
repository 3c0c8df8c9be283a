"""The smoother against one dense solution of everything at once."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from stereotrack_core.filtering.linearisation import Information
from stereotrack_core.filtering.smoothing import Walk, smooth, smooth_uneven


def problem(seed: int, count: int = 6, N: int = 4, known: int = 3):
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(N, N))
    F = np.eye(N) + 0.2 * rng.normal(size=(N, N))
    walk = Walk(
        F,
        rng.normal(size=(count - 1, N)),
        rng.uniform(0.1, 1.0, (count - 1, N)),
        rng.normal(size=N),
        root @ root.T + np.eye(N),
    )
    measured = []
    for k in range(count):
        H = rng.normal(size=(2, known)) if k % 2 else np.zeros((2, known))
        measured.append(Information(H.T @ H, H.T @ rng.normal(size=2)))
    return walk, measured


def dense(walk: Walk, measured):
    """Mean and covariance of all frames from their joint normal equations."""
    count, N = len(measured), len(walk.mean)
    A, b = np.zeros((count * N, count * N)), np.zeros(count * N)
    first = np.linalg.inv(walk.P)
    A[:N, :N] += first
    b[:N] += first @ walk.mean
    for k, seen in enumerate(measured):
        at = slice(k * N, k * N + len(seen.b))
        A[at, at] += seen.A
        b[at] += seen.b
    for k in range(count - 1):
        row = np.zeros((N, count * N))
        row[:, k * N : (k + 1) * N] = -walk.F
        row[:, (k + 1) * N : (k + 2) * N] = np.eye(N)
        A += row.T @ (row / walk.Q[k][:, None])
        b += row.T @ (walk.c[k] / walk.Q[k])
    P = np.linalg.inv(A)
    return (P @ b).reshape(count, N), P


@given(st.integers(0, 2**16))
def test_forward_and_backward_equal_the_dense_solution(seed):
    walk, measured = problem(seed)
    found, (mean, P) = smooth(walk, measured), dense(walk, measured)
    N = len(walk.mean)
    np.testing.assert_allclose(found.mean, mean, atol=1e-8)
    for k in range(len(measured)):
        at = slice(k * N, (k + 1) * N)
        np.testing.assert_allclose(found.P[k], P[at, at], atol=1e-8)


@given(st.integers(0, 2**16))
def test_expected_squares_of_the_noise_equal_the_dense_ones(seed):
    walk, measured = problem(seed)
    found, (mean, P) = smooth(walk, measured), dense(walk, measured)
    N = len(walk.mean)
    for k in range(len(measured) - 1):
        row = np.zeros((N, len(P)))
        row[:, k * N : (k + 1) * N] = -walk.F
        row[:, (k + 1) * N : (k + 2) * N] = np.eye(N)
        left = row @ mean.ravel() - walk.c[k]
        np.testing.assert_allclose(
            found.noise[k], left**2 + np.diagonal(row @ P @ row.T), atol=1e-8
        )


COUNT, NOISE = 60, 1.0


def seen(rng):
    """A state of two numbers of which the first jumps once, the walk, and its measurements."""
    true = np.zeros((COUNT, 2))
    true[COUNT // 2 :, 0] = 20.0
    z = true + NOISE * rng.normal(size=true.shape)
    walk = Walk(
        np.eye(2), np.zeros((COUNT - 1, 2)), np.ones((COUNT - 1, 2)), np.zeros(2), 1e4 * np.eye(2)
    )
    return true, walk, [Information(np.eye(2) / NOISE**2, row / NOISE**2) for row in z]


def off(found, true):
    return float(np.sqrt(np.mean((found.mean - true) ** 2)))


def test_stillness_and_a_jump_are_both_kept(rng):
    true, walk, measured = seen(rng)
    even, uneven = smooth(walk, measured), smooth_uneven(walk, measured, np.arange(2))
    assert off(uneven, true) < 0.5 * off(even, true)
    jump = uneven.mean[COUNT // 2, 0] - uneven.mean[COUNT // 2 - 1, 0]
    assert abs(jump - 20.0) < 1.5


def test_what_it_says_of_its_certainty_is_right(rng):
    true, walk, measured = seen(rng)
    found = smooth_uneven(walk, measured, np.arange(2))
    sigma = np.sqrt(np.einsum("kii->ki", found.P))
    assert (sigma > 0.0).all()
    assert np.mean(np.abs(found.mean - true) < 2.5 * sigma) > 0.9
