"""Random problems for filters."""

import numpy as np


def covariance(rng, n, scale=1.0):
    """Positive definite matrix (n, n) that is far from diagonal."""
    root = rng.normal(size=(n, n)) / np.sqrt(n) + 0.5 * np.eye(n)
    return scale * (root @ root.T)


def curved(rng, n, m, curvature=0.4):
    """Function from (n,) to (m,) with moderate second derivatives."""
    A, B, phase = rng.normal(size=(m, n)), curvature * rng.normal(size=(m, n)), rng.normal(size=m)

    def h(x):
        return A @ x + np.sin(B @ x + phase)

    return h
