"""A Kalman filter over all frames and back again (Rauch, Tung, Striebel; DOI 10.2514/3.3166).

Numbers are error states at known points of linearisation, so that everything here is linear:
x_k+1 = F x_k + c_k + w_k with w_k of covariance Q_k, and measurements as information A_k, b_k.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from stereotrack_core.arrays import FloatArray
from stereotrack_core.filtering.linearisation import Information, posterior


@dataclass(frozen=True, eq=False)
class Walk:
    """How a state goes on from frame to frame.

    Attributes
    ----------
    F : (N, N) float64
    c : (K - 1, N) float64
    Q : (K - 1, N) float64
        Diagonals.
    mean : (N,) float64
        Of the first frame, before its measurements.
    P : (N, N) float64
        Its covariance.
    """

    F: FloatArray
    c: FloatArray
    Q: FloatArray
    mean: FloatArray
    P: FloatArray


@dataclass(frozen=True, eq=False)
class Smooth:
    """What all measurements say about all frames.

    Attributes
    ----------
    mean : (K, N) float64
    P : (K, N, N) float64
    noise : (K - 1, N) float64
        Expected squares of w.
    """

    mean: FloatArray
    P: FloatArray
    noise: FloatArray


def smooth(walk: Walk, measured: list[Information]) -> Smooth:
    """Forward by Kalman's filter, then backward.

    The measurements may know fewer numbers than the state has: its first ones.
    """
    count, N = len(measured), len(walk.mean)
    mean, P = np.empty((count, N)), np.empty((count, N, N))
    gain, before = np.empty((max(count - 1, 0), N, N)), np.empty((count, N))
    expected, spread = walk.mean, walk.P
    for k, seen in enumerate(measured):
        inverse = _inverse(spread)
        if k:
            gain[k - 1] = P[k - 1] @ walk.F.T @ inverse
        before[k] = expected
        correction, P[k] = posterior(inverse, expected, _padded(seen, N))
        mean[k] = correction
        if k + 1 < count:
            expected = walk.F @ mean[k] + walk.c[k]
            spread = walk.F @ P[k] @ walk.F.T + np.diag(walk.Q[k])
    noise = np.empty((max(count - 1, 0), N))
    for k in reversed(range(count - 1)):
        C, predicted = gain[k], walk.F @ P[k] @ walk.F.T + np.diag(walk.Q[k])
        mean[k] += C @ (mean[k + 1] - before[k + 1])
        back = P[k] + C @ (P[k + 1] - predicted) @ C.T
        P[k] = 0.5 * (back + back.T)
        across = walk.F @ C @ P[k + 1]
        w = mean[k + 1] - walk.F @ mean[k] - walk.c[k]
        left = P[k + 1] + walk.F @ P[k] @ walk.F.T - across - across.T
        noise[k] = w * w + np.maximum(np.diagonal(left), 0.0)
    return Smooth(mean, P, noise)


def _inverse(P: FloatArray) -> FloatArray:
    factor = scipy.linalg.cho_factor(P)
    result: FloatArray = scipy.linalg.cho_solve(factor, np.eye(len(P)))
    return 0.5 * (result + result.T)


def _padded(seen: Information, size: int) -> Information:
    known = len(seen.b)
    A, b = np.zeros((size, size)), np.zeros(size)
    A[:known, :known], b[:known] = seen.A, seen.b
    return Information(A, b)
