"""The smoother of Rauch, Tung and Striebel (DOI 10.2514/3.3166): one step back, and all frames.

Numbers are error states at known points of linearisation, so that everything is linear.
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.filtering.linearisation import Information, inverse, posterior


def backward_step(
    P: FloatArray, predicted: FloatArray, carried: BoolArray, after: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Go one frame back: C = P predicted^-1 (n, n) and P + C (after - predicted) C' (n, n).

    P is the filtered covariance, `predicted` the one that the next frame's correction began from,
    `after` the smoothed one of the next frame. The next state is this one plus noise where it was
    `carried` (n,); elsewhere it was drawn anew and tells nothing about this one but through
    correlations: C is zero there.

    A prediction that is in some direction more certain than P, as one whose parts were widened by
    different factors can be, is no random walk; it is widened until it is one, so that P never
    becomes indefinite.
    """
    gain = np.zeros_like(P)
    if not carried.any():
        return gain, P
    block = np.ix_(carried, carried)
    now, prior = P[block], 0.5 * (predicted[block] + predicted[block].T)
    values, vectors = np.linalg.eigh(prior - now)
    prior = now + (vectors * np.maximum(values, 0.0)) @ vectors.T  # what a process noise can add
    factor = scipy.linalg.cho_factor(prior)
    C = scipy.linalg.cho_solve(factor, P[carried]).T
    gain[:, carried] = C
    return gain, _smoothed(P, C, prior, after[block])


def _smoothed(P: FloatArray, C: FloatArray, predicted: FloatArray, after: FloatArray) -> FloatArray:
    """P + C (after - predicted) C'."""
    back: FloatArray = P + C @ (after - predicted) @ C.T
    return 0.5 * (back + back.T)


@dataclass(frozen=True, eq=False)
class Walk:
    """How a state goes on: x_k+1 = F x_k + c_k + w_k, w_k of covariance Q_k."""

    F: FloatArray  # (N, N)
    c: FloatArray  # (K - 1, N)
    Q: FloatArray  # (K - 1, N). Diagonals.
    mean: FloatArray  # (N,). Of the first frame, before its measurements.
    P: FloatArray  # (N, N). Its covariance.


@dataclass(frozen=True, eq=False)
class Smooth:
    """What all measurements say about all frames."""

    mean: FloatArray  # (K, N)
    P: FloatArray  # (K, N, N)
    noise: FloatArray  # (K - 1, N). Expected squares of w.


def smooth(walk: Walk, measured: list[Information]) -> Smooth:
    """A Kalman filter over all frames and back; A_k, b_k may know the first numbers alone."""
    count, N = len(measured), len(walk.mean)
    mean, P = np.empty((count, N)), np.empty((count, N, N))
    gain, before = np.empty((max(count - 1, 0), N, N)), np.empty((count, N))
    expected, spread = walk.mean, walk.P
    for k, seen in enumerate(measured):
        known = inverse(spread)
        if k:
            gain[k - 1] = P[k - 1] @ walk.F.T @ known
        before[k] = expected
        padded, size = Information(np.zeros((N, N)), np.zeros(N)), len(seen.b)
        padded.A[:size, :size], padded.b[:size] = seen.A, seen.b
        mean[k], P[k] = posterior(known, expected, padded)
        if k + 1 < count:
            expected = walk.F @ mean[k] + walk.c[k]
            spread = walk.F @ P[k] @ walk.F.T + np.diag(walk.Q[k])
    noise = np.empty((max(count - 1, 0), N))
    for k in reversed(range(count - 1)):
        C, predicted = gain[k], walk.F @ P[k] @ walk.F.T + np.diag(walk.Q[k])
        mean[k] += C @ (mean[k + 1] - before[k + 1])
        P[k] = _smoothed(P[k], C, predicted, P[k + 1])
        across = walk.F @ C @ P[k + 1]
        w = mean[k + 1] - walk.F @ mean[k] - walk.c[k]
        left = P[k + 1] + walk.F @ P[k] @ walk.F.T - across - across.T
        noise[k] = w * w + np.maximum(np.diagonal(left), 0.0)
    return Smooth(mean, P, noise)


_TAIL = 1.0  # degrees of freedom of the t-distribution: few, for still phases and jumps
_ROUNDS = 15
_SMALLEST = 1e-4  # least part of a step's expected variance that may be left of it


def smooth_uneven(walk: Walk, measured: list[Information], group: IntArray) -> Smooth:
    """Smooth a walk whose steps are small most of the time and large now and then.

    The steps of each `group` (N,) of numbers, counted from 0, have Student's t-distribution. Its
    scale, which begins at the walk's Q, and the size of each step are estimated from all K frames
    by expectation and maximisation (DOI 10.2307/2290063).
    """
    if len(measured) < 2:
        return smooth(walk, measured)
    of = (group == np.arange(group.max() + 1)[:, None]).astype(np.float64)
    size = of.sum(axis=1)
    start: FloatArray = walk.Q.mean(axis=0) @ of.T / size
    variance, factor = start, np.ones((len(walk.Q), len(size)))
    for _ in range(_ROUNDS):
        found = smooth(replace(walk, Q=(variance * factor)[:, group]), measured)
        squared = found.noise @ of.T / variance
        factor = (_TAIL + squared) / (_TAIL + size)
        variance = variance * np.mean(squared / factor, axis=0) / size
        variance = np.maximum(variance, _SMALLEST * start)
    return found
