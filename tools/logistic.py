"""Logistic regression of "lost" on the signs of it, for those tools that fit coefficients."""

import numpy as np
import scipy.optimize
from scipy.special import expit

from stereotrack_core.arrays import BoolArray, FloatArray

FRAMES_OF_ONE = 3.0  # successive frames show nearly the same: so many count as one example


def fitted(
    signs: FloatArray, lost: BoolArray, shrinkage: float, rising: bool = False
) -> FloatArray:
    """Constant and slopes (1 + S,) of a logistic regression with shrunk slopes.

    Parameters
    ----------
    signs : (N, S) float64
    lost : (N,) bool
    shrinkage : float
        Examples that speak for slopes of 0 in units of the signs' own spread.
    rising : bool
        Whether no slope may be below 0.
    """
    middle, spread = signs.mean(axis=0), np.maximum(signs.std(axis=0), 1e-6)
    X = np.column_stack([np.ones(len(signs)), (signs - middle) / spread])
    y = lost.astype(np.float64)

    def cost(b: FloatArray) -> tuple[float, FloatArray]:
        z = X @ b
        against = np.sum(np.logaddexp(0.0, z) - y * z) / FRAMES_OF_ONE
        slope = X.T @ (expit(z) - y) / FRAMES_OF_ONE
        shrunk = np.append(0.0, b[1:])
        return against + 0.5 * shrinkage * shrunk @ shrunk, slope + shrinkage * shrunk

    least = [-np.inf, *[0.0 if rising else -np.inf] * signs.shape[1]]
    bounds = scipy.optimize.Bounds(least)
    start = np.zeros(X.shape[1])
    b = scipy.optimize.minimize(cost, start, jac=True, method="L-BFGS-B", bounds=bounds).x
    slopes = b[1:] / spread
    return np.append(b[0] - slopes @ middle, slopes)
