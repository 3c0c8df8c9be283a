"""The point nearest to several rays."""

from __future__ import annotations

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray


def nearest_to_rays(origins: FloatArray, directions: FloatArray) -> FloatArray:
    """Point with the least sum of squared distances to rays.

    Solves sum (I - d d^T) (p - o) = 0 over the rays (o, d).

    Parameters
    ----------
    origins : (..., V, 3) float64
    directions : (..., V, 3) float64
        Unit vectors; rays with NaN are left out.

    Returns
    -------
    (..., 3) float64
        NaN where fewer than two rays are known or all are parallel.
    """
    o = np.asarray(origins, dtype=np.float64)
    d = np.asarray(directions, dtype=np.float64)
    o, d = np.broadcast_arrays(o, d)
    known: BoolArray = np.isfinite(np.concatenate([o, d], axis=-1)).all(axis=-1)
    o, d = np.where(known[..., None], o, 0.0), np.where(known[..., None], d, 0.0)
    across = known[..., None, None] * np.eye(3) - d[..., :, None] * d[..., None, :]
    matrix = across.sum(axis=-3)
    right_side = np.einsum("...vij,...vj->...i", across, o)
    solvable = (known.sum(axis=-1) >= 2) & (np.linalg.cond(matrix) < 1e8)
    matrix = np.where(solvable[..., None, None], matrix, np.eye(3))
    points: FloatArray = np.linalg.solve(matrix, right_side[..., None])[..., 0]
    return np.where(solvable[..., None], points, np.nan)
