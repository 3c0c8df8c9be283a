"""Points from rays and sightings, linear and robust in raw pixels; distances of segments."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from itertools import combinations

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.rotation import skew


def segment_distance(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> FloatArray:
    """Least distances (...) between segments, or points, a to b and c to d, all (..., 3)."""
    s, t = nearest_on_segments(a, b, c, d)
    apart = a + s[..., None] * (b - a) - c - t[..., None] * (d - c)
    return np.sqrt(_dot(apart, apart))


def nearest_on_segments(
    a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Shares (...), 0 to 1, from a to b and from c to d where two segments are nearest.

    Ericson, Real-Time Collision Detection, section 5.1.9.
    """
    u, v, w = b - a, d - c, a - c
    uu, vv, uv = _dot(u, u), _dot(v, v), _dot(u, v)
    uw, vw = _dot(u, w), _dot(v, w)
    determinant = uu * vv - uv * uv
    crossing = determinant > 1e-12 * uu * vv
    s = np.clip((uv * vw - uw * vv) / np.where(crossing, determinant, np.inf), 0.0, 1.0)
    t = np.clip((uv * s + vw) / np.where(vv > 0, vv, np.inf), 0.0, 1.0)
    s = np.clip((uv * t - uw) / np.where(uu > 0, uu, np.inf), 0.0, 1.0)
    return s, t


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("...i,...i->...", a, b))


_SINGULAR = 1e8
_STEP = 1e-6
_NEAREST = 1e-6
_GROSS = 8.0  # standard deviations beyond which a sighting has no weight
_OUTLIER_WEIGHT = 0.05
_ROUNDS = 40
_STILL = 1e-10  # metres; a step shorter than this ends the search
_UNPLACED = 1e12


def nearest_to_rays(
    origins: FloatArray, directions: FloatArray, weight: FloatArray | None = None
) -> FloatArray:
    """Point (..., 3) with the least sum of squared distances to rays, NaN without one.

    Solves sum w (I - d d^T) (p - o) = 0 over origins (..., V, 3), unit directions (..., V, 3) and
    weights (..., V); rays with NaN are left out.
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
    points = np.linalg.solve(matrix, right_side[..., None])[..., 0]
    return np.where(solvable[..., None], points, np.nan)


def covariance_of_rays(directions: FloatArray, weight: FloatArray) -> FloatArray:
    """Covariances (..., 3, 3) of points of :func:`nearest_to_rays`, or infinite.

    The weights (..., V) are one over the variance of a ray at the point.
    """
    matrix = _across(directions, weight).sum(axis=-3)
    solvable = np.linalg.cond(matrix) < _SINGULAR
    inverse = np.linalg.inv(np.where(solvable[..., None, None], matrix, np.eye(3)))
    return np.where(solvable[..., None, None], inverse, np.inf)


def _across(directions: FloatArray, weight: FloatArray | None) -> FloatArray:
    """W (I - d d^T) (..., V, 3, 3) of rays; 0 for those that are not known."""
    d = np.asarray(directions, dtype=np.float64)
    w = np.ones(d.shape[:-1]) if weight is None else np.broadcast_to(weight, d.shape[:-1])
    known = np.isfinite(d).all(axis=-1) & np.isfinite(w)
    d, w = np.where(known[..., None], d, 0.0), np.where(known, w, 0.0)
    return w[..., None, None] * (np.eye(3) - d[..., :, None] * d[..., None, :])


@dataclass(frozen=True, eq=False)
class Sightings:
    """One point in the images of V cameras; errors count in raw pixels.

    The lens is taken to be straight around every sighting: the error is A (n - p), with sighting n
    and point p undistorted, and the derivative A of raw pixels by these.
    """

    rotation: FloatArray  # (V, 3, 3)
    translation: FloatArray  # (V, 3), metres; camera_from_world of every camera
    place: FloatArray  # (V, 2); undistorted image coordinates of the sightings
    raw_from_place: FloatArray  # (V, 2, 2); derivative of raw pixels there
    sigma: FloatArray  # (V,); standard deviations in raw pixels per axis

    @staticmethod
    def of(cameras: Sequence[Camera], pixels: FloatArray, sigma: FloatArray) -> Sightings:
        """Sightings at raw pixels (V, 2), all known."""
        places = [camera.normalised(pixel) for camera, pixel in zip(cameras, pixels, strict=True)]
        slopes = [_raw_from_place(c, place) for c, place in zip(cameras, places, strict=True)]
        return Sightings(
            np.array([camera.camera_from_world.rotation for camera in cameras]),
            np.array([camera.camera_from_world.translation for camera in cameras]),
            np.array(places),
            np.array(slopes),
            np.asarray(sigma, dtype=np.float64),
        )

    def without(self, view: int) -> Sightings:
        """All but one of them."""
        kept = np.arange(len(self.sigma)) != view
        return Sightings(*(getattr(self, field.name)[kept] for field in fields(self)))

    @cached_property
    def rays(self) -> tuple[FloatArray, FloatArray]:
        """Optical centres (V, 3) and unit directions (V, 3), world."""
        centres = -np.einsum("vji,vj->vi", self.rotation, self.translation)
        ahead = np.concatenate([self.place, np.ones((len(self.place), 1))], axis=1)
        directions = np.einsum("vji,vj->vi", self.rotation, ahead)
        return centres, directions / np.linalg.norm(directions, axis=1, keepdims=True)

    def residuals(self, world: FloatArray) -> FloatArray:
        """Sighting minus picture (..., V, 2) of points (..., 3), raw pixels; NaN from behind."""
        in_camera = np.einsum("vij,...j->...vi", self.rotation, world) + self.translation
        depth = in_camera[..., 2:]
        with np.errstate(divide="ignore", invalid="ignore"):
            picture = np.where(depth > _NEAREST, in_camera[..., :2] / depth, np.nan)
        return np.asarray(np.einsum("vij,...vj->...vi", self.raw_from_place, self.place - picture))

    def jacobian(self, world: FloatArray) -> FloatArray:
        """Derivative (V, 2, 3) of the pictures of a point (3,), raw pixels per metre."""
        x, y, z = (self.rotation @ world + self.translation).T
        slope = np.zeros((len(x), 2, 3))
        slope[:, 0, 0] = slope[:, 1, 1] = 1.0 / z
        slope[:, 0, 2], slope[:, 1, 2] = -x / z**2, -y / z**2
        return self.raw_from_place @ slope @ self.rotation


@dataclass(frozen=True, eq=False)
class SeenPoint:
    """A point (3,), world, metres, and how well it is known."""

    world: FloatArray
    covariance: FloatArray
    """(3, 3), square metres, follows from the sigmas and is larger where the sightings contradict
    each other more than these say; `outlier` (V,) are those that fit none of the others."""
    outlier: BoolArray


def point_of_sightings(sightings: Sightings) -> SeenPoint | None:
    """The point by least squares with Tukey's weights (1 - (r / 8 sigma)^2)^2.

    From the best candidate of two rays; None where rays do not meet in front of two cameras.
    """
    world = _best_candidate(sightings)
    if world is None:
        return None
    for _ in range(_ROUNDS):
        normal, right_side = _normal_equations(sightings, world)
        try:
            step = np.linalg.solve(normal, right_side)
        except np.linalg.LinAlgError:
            return None
        world = world + step
        if not step @ step >= _STILL**2:
            break
    normal, _ = _normal_equations(sightings, world)
    residual = sightings.residuals(world)
    outlier: BoolArray = np.asarray(_weights(sightings, residual) < _OUTLIER_WEIGHT)
    if not np.isfinite(normal).all() or (~outlier).sum() < 2 or np.linalg.cond(normal) > _UNPLACED:
        return None
    scaled = np.square(residual[~outlier] / sightings.sigma[~outlier, None])
    spread = scaled.sum() / (scaled.size - 3)
    return SeenPoint(world, np.linalg.inv(normal) * max(1.0, spread), outlier)


def _raw_from_place(camera: Camera, place: FloatArray) -> FloatArray:
    """Derivative (2, 2) of raw pixels by undistorted image coordinates; NaN beyond the lens."""
    steps = _STEP * np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
    around = np.concatenate([place + steps, np.ones((4, 1))], axis=1)
    raw = camera.project(camera.world_from_camera.apply(around))
    return np.stack([raw[0] - raw[1], raw[2] - raw[3]], axis=1) / (2.0 * _STEP)


def _best_candidate(sightings: Sightings) -> FloatArray | None:
    pairs = list(combinations(range(len(sightings.sigma)), 2))
    if not pairs:
        return None
    centres, directions = sightings.rays
    points = nearest_to_rays(centres[pairs], directions[pairs])
    residual = np.linalg.norm(sightings.residuals(points), axis=-1)
    seen = np.isfinite(residual)
    scaled = np.where(seen, residual / (_GROSS * sightings.sigma), np.inf)
    cost = np.sum(1.0 - np.maximum(1.0 - np.square(scaled), 0.0) ** 3, axis=-1)
    cost[seen.sum(axis=-1) < 2] = np.inf
    best = int(np.argmin(cost))
    return np.asarray(points[best]) if np.isfinite(cost[best]) else None


def _weights(sightings: Sightings, residual: FloatArray) -> FloatArray:
    seen = np.isfinite(residual).all(axis=1)
    if len(residual) == 2:  # nobody can say which one is wrong
        return np.asarray(seen, dtype=np.float64)
    scaled = np.linalg.norm(residual, axis=1) / (_GROSS * sightings.sigma)
    scaled = np.where(seen, scaled, np.inf)
    return np.square(np.maximum(1.0 - np.square(scaled), 0.0))


def _normal_equations(sightings: Sightings, world: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Matrix (3, 3) in 1 / square metres and right side (3,) of the next step."""
    residual = sightings.residuals(world)
    weight = _weights(sightings, residual) / np.square(sightings.sigma)
    used = weight > 0
    jacobian = sightings.jacobian(world)[used].reshape(-1, 3)
    weighted = np.repeat(weight[used], 2)[:, None] * jacobian
    return weighted.T @ jacobian, weighted.T @ residual[used].ravel()


_TOO_NEAR = 1e-6  # metres between two optical centres below which there are no epipolar lines


def epipolar_distance(
    camera: Camera, pixels: FloatArray, other: Camera, other_pixels: FloatArray
) -> FloatArray:
    """Pixels (...) of points (..., 2) from epipolar lines of others; mean of both; may be NaN."""
    one, two = (
        np.concatenate([points, np.ones_like(points[..., :1])], axis=-1)
        for points in (camera.normalised(pixels), other.normalised(other_pixels))
    )
    two_from_one = other.camera_from_world @ camera.world_from_camera
    shift = two_from_one.translation
    if np.linalg.norm(shift) < _TOO_NEAR:
        return np.full(np.broadcast_shapes(one.shape, two.shape)[:-1], np.nan)
    essential = skew(shift / np.linalg.norm(shift)) @ two_from_one.rotation
    line_in_two, line_in_one = one @ essential.T, two @ essential
    product = np.abs(np.sum(two * line_in_two, axis=-1))
    with np.errstate(divide="ignore", invalid="ignore"):
        in_two = product / np.linalg.norm(line_in_two[..., :2], axis=-1) * other.focal
        in_one = product / np.linalg.norm(line_in_one[..., :2], axis=-1) * camera.focal
    return np.asarray(0.5 * (in_one + in_two))
