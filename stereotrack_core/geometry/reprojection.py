"""Projection, differentiated: what a step in the world does to a raw pixel, and back to a ray."""

from __future__ import annotations

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.geometry.camera import Camera

_STEP = 1e-4
"""Metres; half the way over which a projection is differentiated."""

_ROUNDS = 40
_STILL = 1e-11
"""Metres; a step shorter than this ends the search."""


def pixel_jacobian(camera: Camera, points_world: FloatArray) -> FloatArray:
    """Derivatives (..., 2, 3) of raw pixels by world points (..., 3), pixels per metre.

    By central differences, so that it holds for every lens; NaN where a point cannot be seen.
    """
    points = np.asarray(points_world, dtype=np.float64)
    steps = _STEP * np.concatenate([np.eye(3), -np.eye(3)])
    moved = camera.project(points[..., None, :] + steps)
    difference = (moved[..., :3, :] - moved[..., 3:, :]) / (2.0 * _STEP)
    result: FloatArray = np.swapaxes(difference, -1, -2)
    return result


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
    ahead = np.array([0.0, _STEP, -_STEP])[:, None] * direction
    for _ in range(_ROUNDS):
        here, one, two = camera.project(origin + distance * direction + ahead)
        along = (one - two) / (2.0 * _STEP)
        rate = float(along @ along)
        if not rate > 0:
            return np.full(3, np.nan)
        step = float(along @ (pixel - here)) / rate
        distance += step
        if abs(step) < _STILL:
            break
    result: FloatArray = origin + distance * direction
    return result
