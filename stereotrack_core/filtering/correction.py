"""The unscented correction in O(m n^2), equal to the dense one (docs/method.md 4.3)."""

import numpy as np
import scipy

from stereotrack_core.arrays import FloatArray


def normalised(nu: FloatArray, variance: FloatArray) -> float:
    """RMS of differences (m,) over their standard deviations: 1 is as expected; NaN without any."""
    return float(np.sqrt(np.mean(nu**2 / variance))) if len(nu) else float("nan")


def correct(
    P: FloatArray, dX: FloatArray, dY: FloatArray, Wc: FloatArray, nu: FloatArray, R: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Change (n,) of a state by m measurements of independent noise, and its covariance (n, n).

    With V = dY R^-1, G = V dY', q = V nu and M = I + G Wc: dx = dX' Wc M^-1 q and P - dX' Wc M^-1 G
    Wc dX, which are the dense K nu and P - K Pnunu K' of section 2.2.1 by the matrix inversion
    lemma. Only G touches m. The middle point's weight may be negative or zero, hence LU and no
    inverse of Wc.

    P (n, n) is the covariance before, dX (2n + 1, n) and dY (2n + 1, m) are the deviations of sigma
    points and of their images from the weighted mean, Wc (2n + 1,) the covariance weights, nu (m,)
    the innovation, R (m,) the variances. Raises LinAlgError if the innovation's covariance is
    singular.
    """
    V = dY / R
    G = V @ dY.T
    q = V @ nu
    k = len(Wc)
    GW = G * Wc
    right = np.empty((k, k + 1), order="F")
    right[:, 0], right[:, 1:] = q, GW
    # For 29 unknowns the checks around numpy's solve cost as much as the solution.
    *_, solved, info = scipy.linalg.lapack.dgesv(
        np.eye(k) + GW, right, overwrite_a=1, overwrite_b=1
    )
    if info:
        raise np.linalg.LinAlgError("the innovation covariance is singular")
    weighted = dX.T * Wc
    dx = weighted @ solved[:, 0]
    after = P - weighted @ (solved[:, 1:] @ dX)
    return dx, 0.5 * (after + after.T)
