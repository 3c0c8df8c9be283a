"""Scaled sigma points (Julier and Uhlmann 2002, DOI 10.1109/ACC.2002.1025369)."""

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class SigmaWeights:
    """Spread and weights of the 2n + 1 sigma points of an n-dimensional state."""

    spread: float  # factor on the columns of the covariance's square root: sqrt(n + lambda)
    mean: FloatArray
    covariance: FloatArray  # `mean`, `covariance`: (2n + 1,); the first may be negative


def scaled_weights(n: int, alpha: float, beta: float, kappa: float) -> SigmaWeights:
    """Weights of the scaled unscented transform of an n-dimensional state; see section 2.2.4.

    A small `alpha` keeps points close to the mean; `beta` is 2 for a normal distribution; `kappa`
    is the original transform's scaling.
    """
    scale = alpha * alpha * (n + kappa)
    mean = np.full(2 * n + 1, 0.5 / scale)
    mean[0] = 1.0 - n / scale
    covariance = mean.copy()
    covariance[0] += 1.0 - alpha * alpha + beta
    return SigmaWeights(float(np.sqrt(scale)), mean, covariance)


def sigma_deviations(P: FloatArray, weights: SigmaWeights) -> FloatArray:
    """Deviations (2n + 1, n) from the mean, (2.12) to (2.14); LinAlgError for indefinite P."""
    root = weights.spread * np.linalg.cholesky(P).T
    return np.concatenate([np.zeros((1, P.shape[0])), root, -root])
