"""The point that several cameras see at given pixels, by its errors in their raw images."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.triangulation import nearest_to_rays

_STEP = 1e-4
"""Metres; half the way over which a projection is differentiated."""

_GROSS = 8.0
"""Standard deviations beyond which a sighting has no weight."""

_OUTLIER_WEIGHT = 0.05
_ROUNDS = 40
_STILL = 1e-11
"""Metres; a step shorter than this ends the search."""


@dataclass(frozen=True, eq=False)
class Sightings:
    """One point in the images of V cameras.

    Attributes
    ----------
    cameras : sequence of Camera
    pixels : (V, 2) float64
        Raw pixels, all known.
    sigma : (V,) float64
        Standard deviations in pixels per axis.
    """

    cameras: Sequence[Camera]
    pixels: FloatArray
    sigma: FloatArray


@dataclass(frozen=True, eq=False)
class SeenPoint:
    """A point and how well it is known.

    Attributes
    ----------
    world : (3,) float64, metres
    covariance : (3, 3) float64, square metres
        From the sigmas; larger where the sightings contradict each other more than these say.
    residual_px : (V, 2) float64
        Sighting minus projection; NaN where the camera cannot see the point.
    outlier : (V,) bool
        Sightings that fit none of the others.
    """

    world: FloatArray
    covariance: FloatArray
    residual_px: FloatArray
    outlier: BoolArray


def pixel_jacobian(camera: Camera, points_world: FloatArray) -> FloatArray:
    """Derivatives (..., 2, 3) of raw pixels by world points (..., 3), pixels per metre.

    By central differences, so that it holds for every lens; NaN where a point cannot be seen.
    """
    points = np.asarray(points_world, dtype=np.float64)
    steps = _STEP * np.eye(3)
    ahead = camera.project(points[..., None, :] + steps)
    behind = camera.project(points[..., None, :] - steps)
    result: FloatArray = np.swapaxes((ahead - behind) / (2.0 * _STEP), -1, -2)
    return result


def point_of_sightings(sightings: Sightings) -> SeenPoint | None:
    """Robust weighted triangulation in the raw images.

    The rays of every pair of cameras give a candidate; from the one that contradicts the fewest
    sightings least, least squares are iterated with Tukey's weights (1 - (r / 8 sigma)^2)^2.

    Returns
    -------
    SeenPoint or None
        None with fewer than two sightings, or where the rays do not meet in front of two cameras.
    """
    candidates = _candidates(sightings)
    if not len(candidates):
        return None
    world = min(candidates, key=lambda point: _cost(sightings, point))
    if not np.isfinite(_cost(sightings, world)):
        return None
    for _ in range(_ROUNDS):
        normal, step = _normal_equations(sightings, world)
        if normal is None:
            return None
        world = world + step
        if np.linalg.norm(step) < _STILL:
            break
    normal, _ = _normal_equations(sightings, world)
    if normal is None:
        return None
    residual = _residuals(sightings, world)
    weight = _weights(sightings, residual)
    outlier: BoolArray = np.asarray(weight < _OUTLIER_WEIGHT)
    if (~outlier).sum() < 2:
        return None
    scaled = np.square(residual[~outlier] / sightings.sigma[~outlier, None])
    spread = scaled.sum() / (scaled.size - 3)
    return SeenPoint(world, np.linalg.inv(normal) * max(1.0, spread), residual, outlier)


def nearest_on_ray(
    camera: Camera, pixel: FloatArray, origin: FloatArray, direction: FloatArray, start: float
) -> FloatArray:
    """Point (3,) of a ray whose picture is nearest to a pixel, looked for from a distance.

    Parameters
    ----------
    camera : Camera
    pixel : (2,) float64
        Raw pixels.
    origin, direction : (3,) float64, world, metres
        The ray of another camera.
    start : float
        Metres along it.

    Returns
    -------
    (3,) float64
        NaN where the camera does not see the ray there.
    """
    distance = start
    for _ in range(_ROUNDS):
        point = origin + distance * direction
        along = pixel_jacobian(camera, point) @ direction
        rate = float(along @ along)
        if not rate > 0:
            return np.full(3, np.nan)
        step = float(along @ (pixel - camera.project(point))) / rate
        distance += step
        if abs(step) < _STILL:
            break
    result: FloatArray = origin + distance * direction
    return result


def _candidates(sightings: Sightings) -> FloatArray:
    pairs = list(combinations(range(len(sightings.cameras)), 2))
    if not pairs:
        return np.empty((0, 3))
    places = np.array([camera.position_world for camera in sightings.cameras])
    rays = np.array(
        [c.rays_world(p) for c, p in zip(sightings.cameras, sightings.pixels, strict=True)]
    )
    points = nearest_to_rays(places[pairs], rays[pairs])
    return points[np.isfinite(points).all(axis=1)]


def _cost(sightings: Sightings, world: FloatArray) -> float:
    """Tukey's cost; infinite where fewer than two cameras can see the point at all."""
    residual = _residuals(sightings, world)
    seen = np.isfinite(residual).all(axis=1)
    if seen.sum() < 2:
        return float("inf")
    scaled = np.linalg.norm(residual, axis=1) / (_GROSS * sightings.sigma)
    inside = np.maximum(1.0 - np.square(np.where(seen, scaled, np.inf)), 0.0)
    return float(np.sum(1.0 - inside**3))


def _residuals(sightings: Sightings, world: FloatArray) -> FloatArray:
    places = [camera.project(world) for camera in sightings.cameras]
    result: FloatArray = sightings.pixels - np.array(places)
    return result


def _weights(sightings: Sightings, residual: FloatArray) -> FloatArray:
    if len(residual) == 2:  # nobody can say which one is wrong
        return np.asarray(np.isfinite(residual).all(axis=1), dtype=np.float64)
    scaled = np.linalg.norm(residual, axis=1) / (_GROSS * sightings.sigma)
    scaled = np.where(np.isfinite(scaled), scaled, np.inf)
    result: FloatArray = np.square(np.maximum(1.0 - np.square(scaled), 0.0))
    return result


def _normal_equations(
    sightings: Sightings, world: FloatArray
) -> tuple[FloatArray | None, FloatArray]:
    """Matrix (3, 3) in 1 / square metres and the step (3,); None where it is singular."""
    residual = _residuals(sightings, world)
    weight = _weights(sightings, residual) / np.square(sightings.sigma)
    matrix, right_side = np.zeros((3, 3)), np.zeros(3)
    for camera, own, error in zip(sightings.cameras, weight, residual, strict=True):
        if own > 0:
            jacobian = pixel_jacobian(camera, world)
            matrix += own * (jacobian.T @ jacobian)
            right_side += own * (jacobian.T @ error)
    if not np.isfinite(matrix).all() or np.linalg.cond(matrix) > 1e12:
        return None, np.zeros(3)
    step: FloatArray = np.asarray(np.linalg.solve(matrix, right_side), dtype=np.float64)
    return matrix, step
