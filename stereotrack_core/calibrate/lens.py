"""Lens models that can be estimated: projection with analytic derivatives, and their order."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform

PINHOLE_COEFFICIENTS, FISHEYE_COEFFICIENTS = 8, 4
_AXIS = 1e-10  # squared slope below which a fisheye lens is expanded about its axis


@dataclass(frozen=True)
class LensModel:
    """Distortion coefficients that are estimated, in OpenCV's order; the others are zero."""

    name: str
    estimated: tuple[int, ...]
    fisheye: bool = False
    stored: int = 4  # number of coefficients that are written

    @property
    def free(self) -> BoolArray:
        """Mask of f_x, f_y, c_x, c_y and the coefficients that are estimated."""
        count = FISHEYE_COEFFICIENTS if self.fisheye else PINHOLE_COEFFICIENTS
        flags = np.zeros(4 + count, dtype=bool)
        flags[:4] = True
        flags[[4 + i for i in self.estimated]] = True
        return flags


RADIAL = LensModel("radial", (0, 1))
BROWN = LensModel("brown", (0, 1, 2, 3))
FISHEYE = LensModel("fisheye", (0, 1, 2, 3), fisheye=True)
BROWN5 = LensModel("brown5", (0, 1, 2, 3, 4), stored=5)
RATIONAL = LensModel("rational", (0, 1, 2, 3, 4, 5, 6, 7), stored=8)

LENS_MODELS = {model.name: model for model in (RADIAL, BROWN, FISHEYE, BROWN5, RATIONAL)}
"""By the number of coefficients: 2 (k1, k2), 4 (and p1, p2), 4 of a fisheye lens, 5 (and k3) and 8
(and k4, k5, k6)."""


@dataclass(frozen=True, eq=False)
class Lens:
    """Values of a lens: f_x, f_y, c_x, c_y in pixels and 8 coefficients, or 4 of a fisheye lens."""

    model: LensModel
    values: FloatArray  # (12,) or (8,)

    @property
    def focal(self) -> float:
        """Mean focal length in pixels."""
        return float(0.5 * (self.values[0] + self.values[1]))

    def as_model(self, model: LensModel) -> Lens:
        """The same lens to begin the estimation of a richer model with."""
        values = np.zeros(model.free.size)
        values[:4] = self.values[:4]
        if model.fisheye == self.model.fisheye:
            values[4:] = self.values[4:]
        return Lens(model, np.where(model.free, values, 0.0))

    def camera(self, name: str, size: tuple[int, int], camera_from_world: RigidTransform) -> Camera:
        """The camera with this lens; `size` is width and height in pixels."""
        f_x, f_y, c_x, c_y = self.values[:4]
        matrix = np.array([[f_x, 0.0, c_x], [0.0, f_y, c_y], [0.0, 0.0, 1.0]])
        distortions = self.values[4 : 4 + self.model.stored].copy()
        return Camera(name, *size, matrix, distortions, self.model.fisheye, camera_from_world)


def lens_of(camera: Camera, remedy: str = "") -> Lens:
    """Lens of a calibrated camera. Raises InputError if it has more than eight coefficients."""
    if camera.distortions.size > PINHOLE_COEFFICIENTS:
        what = f"its lens has {camera.distortions.size} distortion coefficients"
        raise InputError(what, f"camera {camera.name}", remedy)
    models = [m for m in LENS_MODELS.values() if m.fisheye == camera.fisheye and m is not RADIAL]
    fitting = [m for m in models if m.stored == camera.distortions.size]
    model = fitting[0] if fitting else max(models, key=lambda m: m.stored)
    values = np.zeros(model.free.size)
    values[:4] = (*camera.matrix[[0, 1], [0, 1]], *camera.matrix[:2, 2])
    values[4 : 4 + camera.distortions.size] = camera.distortions
    return Lens(model, values)


def projected(lens: Lens, points: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Raw pixels (N, 2) of points (N, 3), metres in the camera frame, in front of the camera.

    OpenCV's pinhole or fisheye model; also derivatives by the point (N, 2, 3) and the lens's
    values.
    """
    f_x, f_y, c_x, c_y = lens.values[:4]
    inverse = 1.0 / points[:, 2]
    x, y = points[:, 0] * inverse, points[:, 1] * inverse
    s = x * x + y * y
    g, g_s, g_k = (_fisheye if lens.model.fisheye else _rational)(lens.values[4:], s)
    distorted = np.stack([x * g, y * g], axis=1)
    slope = np.empty((len(points), 2, 2))
    slope[:, 0, 0], slope[:, 1, 1] = g + 2 * x * x * g_s, g + 2 * y * y * g_s
    slope[:, 0, 1] = slope[:, 1, 0] = 2 * x * y * g_s
    by_k = np.zeros((len(points), 2, lens.values.size - 4))
    radial = [0, 1, 2, 3] if lens.model.fisheye else [0, 1, 4, 5, 6, 7]
    by_k[:, 0, radial], by_k[:, 1, radial] = x[:, None] * g_k, y[:, None] * g_k
    if not lens.model.fisheye:
        p1, p2 = lens.values[6:8]
        by_k[:, 0, 2], by_k[:, 0, 3] = 2 * x * y, s + 2 * x * x
        by_k[:, 1, 2], by_k[:, 1, 3] = s + 2 * y * y, 2 * x * y
        distorted += by_k[:, :, 2] * p1 + by_k[:, :, 3] * p2
        slope[:, 0, 0] += 2 * p1 * y + 6 * p2 * x
        slope[:, 1, 1] += 6 * p1 * y + 2 * p2 * x
        slope[:, 0, 1] += 2 * p1 * x + 2 * p2 * y
        slope[:, 1, 0] += 2 * p1 * x + 2 * p2 * y
    focal = np.array([f_x, f_y])
    by_lens = np.zeros((len(points), 2, lens.values.size))
    by_lens[:, 0, 0], by_lens[:, 1, 1] = distorted[:, 0], distorted[:, 1]
    by_lens[:, 0, 2] = by_lens[:, 1, 3] = 1.0
    by_lens[:, :, 4:] = focal[:, None] * by_k
    by_point = np.empty((len(points), 2, 3))
    by_point[:, :, :2] = focal[:, None] * slope * inverse[:, None, None]
    by_point[:, :, 2] = -(by_point[:, :, 0] * x[:, None] + by_point[:, :, 1] * y[:, None])
    return distorted * focal + (c_x, c_y), by_point, by_lens


def _rational(k: FloatArray, s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Radial factor (N,), its derivatives by s = r^2 (N,) and k1, k2, k3 ... k6 (N, 6)."""
    powers = np.stack([s, s * s, s * s * s], axis=1)
    rates = np.stack([np.ones_like(s), 2 * s, 3 * s * s], axis=1)
    above, below = k[[0, 1, 4]], k[[5, 6, 7]]
    denominator = 1.0 + powers @ below
    g = (1.0 + powers @ above) / denominator
    g_s = (rates @ above - g * (rates @ below)) / denominator
    g_above = powers / denominator[:, None]
    return g, g_s, np.concatenate([g_above, -g[:, None] * g_above], axis=1)


def _fisheye(k: FloatArray, s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Radial factor theta_d / r (N,), its derivatives by s = r^2 (N,) and k1 ... k4 (N, 4)."""
    near = s < _AXIS
    safe = np.where(near, 1.0, s)
    r = np.sqrt(safe)
    theta = np.arctan(r)
    odd = theta[:, None] ** np.array([3, 5, 7, 9])
    even = theta[:, None] ** np.array([2, 4, 6, 8]) * np.array([3, 5, 7, 9])
    g = (theta + odd @ k) / r
    g_s = ((1.0 + even @ k) / (1.0 + safe) - g) / (2.0 * safe)
    g_k = odd / r[:, None]
    g_k[near] = 0.0
    return np.where(near, 1.0, g), np.where(near, k[0] - 1.0 / 3.0, g_s), g_k
