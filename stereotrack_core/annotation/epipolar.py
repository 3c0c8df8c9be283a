"""After a click in one image: the curve in another image on which the same landmark lies.

The ray of the click is straight in the world and, without distortion, in every other image. It is
cut to the working volume and to what the other camera can see, and sampled so closely that straight
lines between the samples are off the distorted curve by less than a tenth of a pixel.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray
from stereotrack_core.depth.points import Volume
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.triangulation import nearest_to_rays

_STEP = 6.0  # pixels between samples, about
_COARSE = 200  # samples with which the part of the ray that the image shows is looked for
_BORDER = 9  # samples along every side of the image, to know what the camera can see at most
_WIDEST = 8.0  # tangent of the largest angle off a camera's axis that is looked at (83 deg)
_GRID = 9  # points along every side of the working volume, to know whether the cameras see it
_HALVINGS = 40
_NEAREST = 1e-3  # metres; nearer to a camera nothing is looked for


@dataclass(frozen=True, eq=False)
class EpipolarCurve:
    """Where a landmark that was clicked in one image can be in another; K samples."""

    pixels: FloatArray
    """(K, 2), raw pixels of the other image, ordered from near to far as the first camera sees
    them; no NaN. Nothing (0, 2) where the other camera sees no part of the ray within the
    volume."""
    distance: FloatArray  # (K,), metres, from the first camera along the ray


def epipolar_curve(
    from_camera: Camera, pixel: FloatArray, to_camera: Camera, volume: Volume
) -> EpipolarCurve:
    """The curve of a click (2,), raw pixels, in another image, cut to the volume and the image."""
    origin = from_camera.position_world
    direction = from_camera.rays_world(np.asarray(pixel, dtype=np.float64))
    near, far = ray_in_volume(origin, direction, volume)
    if far > near:
        near, far = _ray_in_view(to_camera, origin, direction, (near, far))
    if not far > near:
        return EpipolarCurve(np.empty((0, 2)), np.empty(0))
    ray = _Ray(to_camera, origin, direction, near, far)
    shares = ray.visible_shares()
    distance = ray.distance(shares)
    pixels = ray.pixels(shares)
    known = np.isfinite(pixels).all(axis=1)
    return EpipolarCurve(pixels[known], distance[known])


def volume_in_sight(volume: Volume, cameras: Sequence[Camera]) -> Volume:
    """The working volume, or one of its size where the cameras look, if they do not see it.

    The volume's default is meant for a person near the world's origin. It is taken where two
    cameras (or the only one) see some of it; otherwise one around the point nearest to all optical
    axes.
    """
    shares = np.linspace(0.0, 1.0, _GRID)
    grid = np.stack(np.meshgrid(shares, shares, shares), axis=-1).reshape(-1, 3)
    points = volume.low + grid * (volume.high - volume.low)
    seen = sum(in_image(camera, camera.project(points)).astype(int) for camera in cameras)
    if not cameras or np.max(seen) >= min(2, len(cameras)):
        return volume
    half = 0.5 * (volume.high - volume.low)
    middle = watched_point(cameras, float(np.linalg.norm(half)))
    return Volume(middle - half, middle + half)


def watched_point(cameras: Sequence[Camera], away: float) -> FloatArray:
    """The point (3,), world, that cameras look at together; else one so far in front of them."""
    origins = np.array([camera.position_world for camera in cameras])
    axes = np.array([camera.camera_from_world.rotation[2] for camera in cameras])
    point = nearest_to_rays(origins, axes)
    if np.isfinite(point).all() and (((point - origins) * axes).sum(axis=1) > 0).all():
        return point
    middle: FloatArray = (origins + away * axes).mean(axis=0)
    return middle


def ray_in_volume(origin: FloatArray, direction: FloatArray, volume: Volume) -> tuple[float, float]:
    """Distances at which a ray enters and leaves the volume; the second is less where it misses.

    `origin` and `direction` (3,), world, metres.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        crossings = (np.stack([volume.low, volume.high]) - origin) / direction
    along = direction == 0
    if (along & ((origin < volume.low) | (origin > volume.high))).any() or along.all():
        return 0.0, -1.0
    low, high = np.sort(crossings[:, ~along], axis=0)
    return max(float(low.max()), _NEAREST), float(high.min())


def in_image(camera: Camera, pixels: FloatArray) -> BoolArray:
    """Whether raw pixels (..., 2) lie on the camera's image; False for NaN."""
    low = pixels >= -0.5
    high = pixels <= np.array([camera.width - 0.5, camera.height - 0.5])
    return np.asarray((low & high).all(axis=-1))


def _ray_in_view(
    camera: Camera, origin: FloatArray, direction: FloatArray, within: tuple[float, float]
) -> tuple[float, float]:
    """The stretch of a ray inside the pyramid that holds all that the camera sees."""
    start = camera.camera_from_world.apply(origin)
    step = camera.camera_from_world.rotation @ direction
    widest = min(_WIDEST, camera.widest_slope)
    across = np.linspace(-0.5, camera.width - 0.5, _BORDER)
    down = np.linspace(-0.5, camera.height - 0.5, _BORDER)
    grid = np.stack(np.meshgrid(across, down), axis=-1)
    border = np.concatenate([grid[0], grid[-1], grid[:, 0], grid[:, -1]])
    slopes = np.nan_to_num(camera.normalised(border), nan=widest, posinf=widest, neginf=-widest)
    low = np.clip(slopes.min(axis=0), -widest, widest)
    high = np.clip(slopes.max(axis=0), -widest, widest)
    near, far = within
    planes = [(0.0, 0.0, 1.0), (1, 0, -low[0]), (-1, 0, high[0]), (0, 1, -low[1]), (0, -1, high[1])]
    for plane in planes:  # inside where the product is positive
        here, growth = float(np.dot(plane, start)), float(np.dot(plane, step))
        if growth > 0:
            near = max(near, -here / growth)
        elif growth < 0:
            far = min(far, -here / growth)
        elif here <= 0:
            return 0.0, -1.0
    return near, far


class _Ray:
    """A stretch of a ray by its share, which runs evenly in the image but for the distortion.

    Between two points at the depths z0 and z1 of the camera, the share u of the way in the image is
    reached at the share u z0 / (u z0 + (1 - u) z1) of the way in the world.
    """

    def __init__(
        self, camera: Camera, origin: FloatArray, direction: FloatArray, near: float, far: float
    ) -> None:
        self._camera, self._origin, self._direction = camera, origin, direction
        self._near, self._far = near, far
        ends = camera.camera_from_world.apply(origin + np.outer([near, far], direction))
        self._z = np.maximum(ends[:, 2], _NEAREST)

    def distance(self, share: FloatArray) -> FloatArray:
        """Distances from the ray's origin."""
        z0, z1 = self._z
        way = share * z0 / (share * z0 + (1.0 - share) * z1)
        result: FloatArray = self._near + (self._far - self._near) * way
        return result

    def pixels(self, share: FloatArray) -> FloatArray:
        """Raw pixels (K, 2) of shares (K,)."""
        distance = self.distance(share)
        return self._camera.project(self._origin + distance[:, None] * self._direction)

    def visible_shares(self) -> FloatArray:
        """Shares (K,) of samples about :data:`_STEP` apart, from border to border of the image."""
        coarse = np.linspace(0.0, 1.0, _COARSE)
        visible = np.flatnonzero(in_image(self._camera, self.pixels(coarse)))
        if not len(visible):
            return np.empty(0)
        first, last = int(visible[0]), int(visible[-1])
        ends = coarse[[first, last]]
        beyond = coarse[[max(first - 1, 0), min(last + 1, _COARSE - 1)]]
        for _ in range(_HALVINGS):
            middle = 0.5 * (ends + beyond)
            inside = in_image(self._camera, self.pixels(middle))
            ends, beyond = np.where(inside, middle, ends), np.where(inside, beyond, middle)
        shares = np.linspace(ends[0], ends[1], _COARSE)
        steps = np.linalg.norm(np.diff(self.pixels(shares), axis=0), axis=1)
        length = np.concatenate([[0.0], np.cumsum(np.nan_to_num(steps))])
        count = max(2, int(np.ceil(length[-1] / _STEP)) + 1)
        return np.interp(np.linspace(0.0, length[-1], count), length, shares)
