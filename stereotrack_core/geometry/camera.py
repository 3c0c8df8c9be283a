"""One lens: intrinsics with distortion, and its place in the world."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import cv2
import numpy as np
from numpy.polynomial import Polynomial

from stereotrack_core.arrays import FloatArray
from stereotrack_core.geometry.transform import RigidTransform

_MANY = 100  # points from which OpenCV is slower than NumPy


_BLOCK = 16  # pixels; codecs store images of whole blocks
PADDED = (
    "the calibration of {} is for images of {} x {} pixels, padded to multiples of 16 to the right "
    "and below; it is used for those of {} x {}"
)
"""What is said of a calibration of padded images: camera, size, and size of the images."""


def is_padded(size: tuple[int, int], shown: tuple[int, int]) -> bool:
    """Whether images of a size are those `shown`, padded right and below to whole blocks."""
    whole = [_BLOCK * -(-side // _BLOCK) for side in shown]
    each = zip(size, shown, whole, strict=True)
    return size != shown and all(one in (own, padded) for one, own, padded in each)


@dataclass(frozen=True, eq=False)
class Camera:
    """A calibrated camera; OpenCV axes (x right, y down, z forward).

    The centre of the top-left pixel of the raw image is (0, 0).
    """

    name: str
    width: int
    height: int
    matrix: FloatArray  # (3, 3); intrinsics in pixels
    distortions: FloatArray  # (k,); OpenCV order: 4, 5, 8, 12 or 14; 4 for a fisheye lens
    fisheye: bool  # whether `distortions` belong to OpenCV's fisheye model
    camera_from_world: RigidTransform
    place_sigma: float = 0.0  # standard deviation (3-D) of its place, metres; 0 if not stated

    @property
    def world_from_camera(self) -> RigidTransform:
        """Place of the camera in the world."""
        return self.camera_from_world.inverse()

    @property
    def position_world(self) -> FloatArray:
        """Optical centre (3,), world, metres."""
        return self.world_from_camera.translation

    @property
    def focal(self) -> float:
        """Mean focal length in pixels."""
        return float(0.5 * (self.matrix[0, 0] + self.matrix[1, 1]))

    def scaled(self, factor: float) -> "Camera":
        """The camera with the lengths of its place multiplied."""
        old = self.camera_from_world
        placed = RigidTransform(old.rotation, factor * old.translation)
        return replace(self, camera_from_world=placed, place_sigma=factor * self.place_sigma)

    @cached_property
    def widest_slope(self) -> float:
        """Distance from the optical axis at z = 1 up to which the distortion grows outwards.

        Radially r' = r N(s) / D(s) with s = r^2, N = 1 + k1 s + k2 s^2 + k3 s^3 and
        D = 1 + k4 s + k5 s^2 + k6 s^3; it turns back where N D + 2 s (N' D - N D') = 0.
        Infinite where it does not turn back, and for a fisheye lens, whose model covers 180 deg.
        """
        if self.fisheye:
            return float("inf")
        k = np.zeros(8)
        k[: min(8, self.distortions.size)] = self.distortions[:8]
        numerator = Polynomial([1, k[0], k[1], k[4]])
        denominator = Polynomial([1, k[5], k[6], k[7]])
        slope = numerator * denominator + 2 * Polynomial([0, 1]) * (
            numerator.deriv() * denominator - numerator * denominator.deriv()
        )
        roots = np.concatenate([slope.trim().roots(), denominator.trim().roots()])
        turns = roots.real[(np.abs(roots.imag) < 1e-9) & (roots.real > 0)]
        return float(np.sqrt(turns.min())) if turns.size else float("inf")

    def project(self, points_world: FloatArray) -> FloatArray:
        """Raw pixels (..., 2) of world points (..., 3); NaN behind or beyond the lens."""
        points = np.asarray(points_world, dtype=np.float64)
        in_camera = self.camera_from_world.apply(points).reshape(-1, 3)
        in_front = in_camera[:, 2] > 1e-6
        if np.isfinite(self.widest_slope):
            aside = np.hypot(in_camera[:, 0], in_camera[:, 1])
            in_front &= aside < self.widest_slope * in_camera[:, 2]
        pixels = np.full((len(in_camera), 2), np.nan)
        if in_front.any():
            pixels[in_front] = self._project_in_front(in_camera[in_front])
        return pixels.reshape(*points.shape[:-1], 2)

    def _project_in_front(self, in_camera: FloatArray) -> FloatArray:
        zero = np.zeros(3)
        if self.fisheye:
            pixels, _ = cv2.fisheye.projectPoints(
                np.ascontiguousarray(in_camera[:, None]), zero, zero, self.matrix, self.distortions
            )
        elif len(in_camera) > _MANY and self.distortions.size <= 12:
            # OpenCV finds derivatives as well, which takes most of the time
            return self._distorted(in_camera[:, :2] / in_camera[:, 2:])
        else:
            pixels, _ = cv2.projectPoints(in_camera, zero, zero, self.matrix, self.distortions)
        return np.asarray(pixels, dtype=np.float64).reshape(-1, 2)

    def _distorted(self, places: FloatArray) -> FloatArray:
        """Raw pixels (N, 2) of undistorted image coordinates (N, 2), by OpenCV's equations."""
        given = np.append(self.distortions, np.zeros(12))[:12]
        k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4 = given
        x, y = places.T
        s, xy = x * x + y * y, x * y
        radial = (1 + s * (k1 + s * (k2 + s * k3))) / (1 + s * (k4 + s * (k5 + s * k6)))
        raw_x = x * radial + 2 * p1 * xy + p2 * (s + 2 * x * x) + s * (s1 + s * s2)
        raw_y = y * radial + p1 * (s + 2 * y * y) + 2 * p2 * xy + s * (s3 + s * s4)
        centre, focal = self.matrix[:2, 2], self.matrix.diagonal()[:2]
        return np.stack([raw_x, raw_y], axis=-1) * focal + centre

    def normalised(self, pixels: FloatArray) -> FloatArray:
        """Undistorted image coordinates (..., 2) at z = 1 of raw pixels (..., 2)."""
        points = np.asarray(pixels, dtype=np.float64)
        if not points.size:
            return points.copy()
        # OpenCV's fisheye functions misread arrays that are not contiguous.
        flat = np.ascontiguousarray(points.reshape(-1, 1, 2))
        if self.fisheye:
            undistorted = cv2.fisheye.undistortPoints(flat, self.matrix, self.distortions)
        else:
            criteria = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 50, 1e-12)
            undistorted = cv2.undistortPoints(
                flat, self.matrix, self.distortions, criteria=criteria
            )
        return np.asarray(undistorted, dtype=np.float64).reshape(points.shape)

    def rays_world(self, pixels: FloatArray) -> FloatArray:
        """Unit directions (..., 3), world, of the rays through raw pixels (..., 2)."""
        flat = self.normalised(pixels)
        directions = np.concatenate([flat, np.ones_like(flat[..., :1])], axis=-1)
        directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
        return directions @ self.camera_from_world.rotation


_STEP = 1e-4  # metres; half the way over which a projection is differentiated
_ROUNDS = 40
_STILL = 1e-11  # metres; a step shorter than this ends the search


def pixel_jacobian(camera: Camera, points_world: FloatArray) -> FloatArray:
    """Central differences (..., 2, 3) of raw pixels by world points (..., 3), px/m, or NaN."""
    points = np.asarray(points_world, dtype=np.float64)
    steps = _STEP * np.concatenate([np.eye(3), -np.eye(3)])
    moved = camera.project(points[..., None, :] + steps)
    difference = (moved[..., :3, :] - moved[..., 3:, :]) / (2.0 * _STEP)
    return np.swapaxes(difference, -1, -2)


def nearest_on_ray(
    camera: Camera, pixel: FloatArray, origin: FloatArray, direction: FloatArray, start: float
) -> FloatArray:
    """Point (3,) of a ray, from `start` metres on, whose picture is nearest to a raw pixel."""
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
    return origin + distance * direction


def variance_by_cameras(cameras: Sequence[Camera]) -> float:
    """Variance per axis, square metres, of points by errors that the cameras state; 0 for none.

    Every camera shows a point off by its own error, and the point lies in their mean. Rotations
    are not counted: a camera that is misplaced is turned so that it shows the person where it did.
    """
    stated = [one.place_sigma**2 / 3.0 for one in cameras]
    return sum(stated) / max(len(stated), 1) ** 2
