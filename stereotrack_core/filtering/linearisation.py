"""Iterated posterior linearisation (docs/method.md 4.4; DOI 10.1109/TSP.2015.2454485)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from stereotrack_core.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class Information:
    """Normal equations gathered from measurements."""

    A: FloatArray  # (n, n). H' R^-1 H.
    b: FloatArray  # (n,). H' R^-1 times the innovation at the point of linearisation.

    def __add__(self, other: Information) -> Information:
        return Information(self.A + other.A, self.b + other.b)


def information(D: FloatArray, nu: FloatArray, R: FloatArray) -> Information:
    """Gather m measurements: Jacobian' D (n, m), innovation nu (m,), variances R (m,)."""
    weighted = D / R
    return Information(weighted @ D.T, weighted @ nu)


def posterior(
    P0_inverse: FloatArray, from_prior: FloatArray, gathered: Information
) -> tuple[FloatArray, FloatArray]:
    """Mean (n,) of the error state, to be added to x_i, and covariance (n, n), given prior and
    measurements.

    `P0_inverse` (n, n): inverse of the prior's covariance; `from_prior` (n,): x_0 - x_i, the
    prior's mean seen from the point of linearisation x_i, at which `gathered` was linearised.
    """
    P = inverse(P0_inverse + gathered.A)
    return P @ (P0_inverse @ from_prior + gathered.b), P


def inverse(P: FloatArray) -> FloatArray:
    """Inverse (n, n) of a symmetric positive definite matrix; raises LinAlgError for others."""
    # LAPACK itself: what SciPy and NumPy check around it takes longer than these small matrices.
    factor, failed = scipy.linalg.lapack.dpotrf(P, lower=1)
    if failed:
        raise np.linalg.LinAlgError("the matrix is not positive definite")
    lower, _ = scipy.linalg.lapack.dpotri(factor, lower=1)
    result: FloatArray = lower + lower.T
    result.flat[:: len(P) + 1] *= 0.5
    return result
