"""Iterated posterior linearisation (method.md 4D; DOI 10.1109/TSP.2015.2454485).

The measurement function is linearised statistically by sigma points of the current posterior,
while the correction is always applied to the frame's prior. Iterating with sigma points of the
prior diverges: at 40 degrees the unscented mean of a hand is off by 91 mm.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from stereotrack_core.arrays import FloatArray
from stereotrack_core.filtering.sigma_points import SigmaWeights


@dataclass(frozen=True, eq=False)
class Linearisation:
    """An affine stand-in of the measurement function: z = mean + H dx + e.

    Attributes
    ----------
    mean : (m,) float64
        Mean of the predicted measurement over the sigma points.
    H : (m, n) float64
        Statistical Jacobian.
    spread : (m,) float64
        Variance of e, the linearisation's own error.
    """

    mean: FloatArray
    H: FloatArray
    spread: FloatArray


def linearised(
    dX: FloatArray, Y: FloatArray, weights: SigmaWeights, P: FloatArray
) -> Linearisation:
    """Linearise by sigma points.

    Parameters
    ----------
    dX : (2n + 1, n) float64
        Deviations of the sigma points.
    Y : (2n + 1, m) float64
        Predicted measurements.
    weights : SigmaWeights
    P : (n, n) float64
        Covariance that the sigma points represent.
    """
    mean = weights.mean @ Y
    dY = Y - mean
    P_xz = (dX.T * weights.covariance) @ dY
    H = scipy.linalg.cho_solve(scipy.linalg.cho_factor(P), P_xz).T
    P_zz = np.einsum("s,sm,sm->m", weights.covariance, dY, dY)
    explained = np.einsum("mn,mn->m", H @ P, H)
    return Linearisation(mean, H, np.maximum(P_zz - explained, 0.0))


@dataclass(frozen=True, eq=False)
class Information:
    """Normal equations gathered from measurements.

    Attributes
    ----------
    A : (n, n) float64
        H' R^-1 H.
    b : (n,) float64
        H' R^-1 times the innovation at the point of linearisation.
    """

    A: FloatArray
    b: FloatArray

    def __add__(self, other: Information) -> Information:
        return Information(self.A + other.A, self.b + other.b)


def information(H: FloatArray, nu: FloatArray, R: FloatArray) -> Information:
    """Gather m measurements: Jacobian H (m, n), innovation nu (m,), variances R (m,)."""
    weighted = H.T / R
    return Information(weighted @ H, weighted @ nu)


def posterior(
    P0_inverse: FloatArray, from_prior: FloatArray, gathered: Information
) -> tuple[FloatArray, FloatArray]:
    """Mean of the error state and covariance given prior and measurements.

    Parameters
    ----------
    P0_inverse : (n, n) float64
        Inverse of the prior's covariance.
    from_prior : (n,) float64
        x_0 - x_i: the prior's mean seen from the point of linearisation.
    gathered : Information
        Linearised at x_i.

    Returns
    -------
    dx : (n,) float64
        To be added to x_i: the minimum of both quadratic forms.
    P : (n, n) float64
    """
    total = P0_inverse + gathered.A
    factor = scipy.linalg.cho_factor(total)
    dx = scipy.linalg.cho_solve(factor, P0_inverse @ from_prior + gathered.b)
    P = scipy.linalg.cho_solve(factor, np.eye(len(dx)))
    return dx, 0.5 * (P + P.T)
