"""How far clicks lie from where a fitted trajectory has their landmarks."""

from __future__ import annotations

import numpy as np

from stereotrack_core.annotation.click_points import ClickPixels
from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.limbs import LIMBS


def click_residuals(clicks: ClickPixels, frame: IntArray, points: FloatArray) -> FloatArray:
    """Distance in pixels from the projected trajectory (F, L, V); NaN where either is missing.

    Parameters
    ----------
    clicks : ClickPixels
    frame : (T,) int64
        Frames of the trajectory, ascending.
    points : (T, L, 3) float64, world, metres
        Landmarks of the trajectory in the order of ``clicks.names``.
    """
    fitted = np.full((len(clicks.frame), len(clicks.names), 3), np.nan)
    _, own, theirs = np.intersect1d(clicks.frame, frame, return_indices=True)
    fitted[own] = points[theirs]
    away = np.full(clicks.pixel.shape[:3], np.nan)
    for v, camera in enumerate(clicks.cameras):
        known = np.isfinite(fitted).all(axis=-1) & np.isfinite(clicks.pixel[:, :, v]).all(axis=-1)
        if known.any():
            difference = clicks.pixel[:, :, v][known] - camera.project(fitted[known])
            away[known, v] = np.linalg.norm(difference, axis=-1)
    return away


def limb_residuals(away: FloatArray, landmarks: LandmarkSet) -> FloatArray:
    """Root mean square residual of each limb's landmarks (F, 6), in the order of ``LIMBS``.

    Parameters
    ----------
    away : (F, L, V) float64, pixels
    landmarks : LandmarkSet
        L landmarks.
    """
    result = np.full((len(away), len(LIMBS)), np.nan)
    limb_of = np.array([LIMBS.index(one.limb) for one in landmarks.landmarks])
    for limb in range(len(LIMBS)):
        own = away[:, limb_of == limb].reshape(len(away), -1)
        count = np.isfinite(own).sum(axis=1)
        squares = np.nansum(own**2, axis=1)
        result[count > 0, limb] = np.sqrt(squares[count > 0] / count[count > 0])
    return result
