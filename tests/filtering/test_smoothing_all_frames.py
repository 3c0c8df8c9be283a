"""The smoother against one dense solution of everything at once."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from stereotrack_core.filtering.linearisation import Information
from stereotrack_core.filtering.smoothing import Walk, smooth


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


def test_one_frame_is_a_plain_correction():
    walk, measured = problem(3, count=2)
    alone = Walk(walk.F, walk.c[:0], walk.Q[:0], walk.mean, walk.P)
    found = smooth(alone, measured[1:])
    mean, P = dense(alone, measured[1:])
    np.testing.assert_allclose(found.mean, mean, atol=1e-9)
    np.testing.assert_allclose(found.P[0], P, atol=1e-9)
    assert len(found.noise) == 0
