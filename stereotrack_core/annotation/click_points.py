"""Clicked landmarks in space: every landmark from its clicks alone, nothing known of a body."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.triangulation import nearest_to_rays


@dataclass(frozen=True, eq=False)
class ClickPixels:
    """Positions of clicks as arrays; F frames, L landmarks, V cameras.

    Attributes
    ----------
    frame : (F,) int64
        Frames that have a click, ascending.
    names : tuple of str
        Landmarks.
    cameras : tuple of Camera
    pixel : (F, L, V, 2) float64
        Raw-image pixels, NaN where nobody gave a position.
    """

    frame: IntArray
    names: tuple[str, ...]
    cameras: tuple[Camera, ...]
    pixel: FloatArray

    def points(self) -> FloatArray:
        """The point nearest to each landmark's rays (F, L, 3), world, metres.

        NaN where fewer than two cameras see it.
        """
        if not self.pixel.size:
            return np.full((*self.pixel.shape[:2], 3), np.nan)
        origins = np.stack([camera.position_world for camera in self.cameras])
        rays = [camera.rays_world(self.pixel[:, :, v]) for v, camera in enumerate(self.cameras)]
        return nearest_to_rays(origins, np.stack(rays, axis=2))


def click_pixels(
    clicks: Iterable[Click], cameras: Mapping[str, Camera], names: Sequence[str]
) -> ClickPixels:
    """Clicks as arrays; deleted ones, and other cameras' and landmarks', are left out."""
    places = {name: i for i, name in enumerate(names)}
    views = {name: v for v, name in enumerate(cameras)}
    kept = [
        (click.frame, places[click.landmark], views[click.camera], *click.position)
        for click in clicks
        if click.position is not None
        and not click.deleted
        and click.landmark in places
        and click.camera in views
    ]
    table = np.array(kept, dtype=np.float64).reshape(-1, 5)
    frame, rows = np.unique(table[:, 0].astype(np.int64), return_inverse=True)
    pixel = np.full((len(frame), len(places), len(views), 2), np.nan)
    pixel[rows, table[:, 1].astype(np.int64), table[:, 2].astype(np.int64)] = table[:, 3:]
    return ClickPixels(frame, tuple(names), tuple(cameras.values()), pixel)


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
