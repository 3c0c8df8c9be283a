"""The point nearest to several rays."""

from __future__ import annotations

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray

_SINGULAR = 1e8


def nearest_to_rays(
    origins: FloatArray, directions: FloatArray, weight: FloatArray | None = None
) -> FloatArray:
    """Point with the least sum of squared distances to rays.

    Solves sum w (I - d d^T) (p - o) = 0 over the rays (o, d) of weight w.

    Parameters
    ----------
    origins : (..., V, 3) float64
    directions : (..., V, 3) float64
        Unit vectors; rays with NaN are left out.
    weight : (..., V) float64, optional
        1 for all where it is not given; rays of weight NaN are left out.

    Returns
    -------
    (..., 3) float64
        NaN where fewer than two rays are known or all are parallel.
    """
    o = np.asarray(origins, dtype=np.float64)
    d = np.asarray(directions, dtype=np.float64)
    o, d = np.broadcast_arrays(o, d)
    known: BoolArray = np.isfinite(np.concatenate([o, d], axis=-1)).all(axis=-1)
    if weight is not None:
        known = known & np.isfinite(weight)
    o, d = np.where(known[..., None], o, 0.0), np.where(known[..., None], d, np.nan)
    across = _across(d, weight)
    matrix = across.sum(axis=-3)
    right_side = np.einsum("...vij,...vj->...i", across, o)
    solvable = (known.sum(axis=-1) >= 2) & (np.linalg.cond(matrix) < _SINGULAR)
    matrix = np.where(solvable[..., None, None], matrix, np.eye(3))
    points: FloatArray = np.linalg.solve(matrix, right_side[..., None])[..., 0]
    return np.where(solvable[..., None], points, np.nan)


def covariance_of_rays(directions: FloatArray, weight: FloatArray) -> FloatArray:
    """Covariances (..., 3, 3) of the points that :func:`nearest_to_rays` gives.

    Parameters
    ----------
    directions : (..., V, 3) float64
    weight : (..., V) float64
        One over the variance of a ray at the point, across its direction.

    Returns
    -------
    (..., 3, 3) float64
        Infinite where the rays do not place a point.
    """
    matrix = _across(directions, weight).sum(axis=-3)
    solvable = np.linalg.cond(matrix) < _SINGULAR
    inverse = np.linalg.inv(np.where(solvable[..., None, None], matrix, np.eye(3)))
    result: FloatArray = np.where(solvable[..., None, None], inverse, np.inf)
    return result


def _across(directions: FloatArray, weight: FloatArray | None) -> FloatArray:
    """W (I - d d^T) (..., V, 3, 3) of rays; 0 for those that are not known."""
    d = np.asarray(directions, dtype=np.float64)
    w = np.ones(d.shape[:-1]) if weight is None else np.broadcast_to(weight, d.shape[:-1])
    known = np.isfinite(d).all(axis=-1) & np.isfinite(w)
    d, w = np.where(known[..., None], d, 0.0), np.where(known, w, 0.0)
    result: FloatArray = w[..., None, None] * (np.eye(3) - d[..., :, None] * d[..., None, :])
    return result
