"""What a network sees of a picture: a square, turned part of it, in RGB with usable contrast.

In the picture and in the part, (0, 0) is the centre of the top left pixel.
"""

from dataclasses import dataclass
from typing import TypeGuard

import cv2
import numpy as np

from stereotrack_core.arrays import Float32Array, FloatArray, ImageArray
from stereotrack_core.geometry.camera import Camera

_EVERY = 4  # only every so many columns and rows are looked at for the brightness

_DARK = 120.0  # grey value of the brightest hundredth of a picture from which it is left as it is
_BRIGHT = 220.0  # grey value that it gets otherwise
_MOST_GAIN = 12.0  # gain above which a black picture would only show its noise

_SLOPE = 0.01
"""Step of depth to the next pixel, relative to the depth, at which shaded depth is half dark: that
of a surface seen at 80 degrees with a focal length of 500 pixels."""


def as_uint8(picture: ImageArray | Float32Array) -> ImageArray:
    """The picture (H, W, 3) BGR or (H, W) grey, uint8, or depth as one: (H, W) metres, float32."""
    return picture if _is_picture(picture) else shaded_depth(picture.astype(np.float32))


def _is_picture(picture: ImageArray | Float32Array) -> TypeGuard[ImageArray]:
    return picture.dtype == np.uint8


def as_rgb(picture: ImageArray) -> ImageArray:
    """Picture (H, W, 3) in RGB with usable contrast, of one (H, W, 3) in BGR or (H, W) in grey."""
    conversion = cv2.COLOR_BGR2RGB if picture.ndim == 3 else cv2.COLOR_GRAY2RGB
    return brightened(np.asarray(cv2.cvtColor(picture, conversion), dtype=np.uint8))


def brightened(picture: ImageArray) -> ImageArray:
    """A dark picture made as bright as a photograph; the same one if it is bright enough."""
    bright = float(np.percentile(picture[::_EVERY, ::_EVERY], 99.0))
    if bright >= _DARK:
        return picture
    return np.asarray(
        cv2.convertScaleAbs(picture, alpha=min(_BRIGHT / max(bright, 1.0), _MOST_GAIN)),
        dtype=np.uint8,
    )


def shaded_depth(depth: Float32Array) -> ImageArray:
    """Grey picture (H, W) of depth in metres: dark where the surface turns away from the camera."""
    filled = np.nan_to_num(depth, nan=0.0)
    measured = filled > 0.0
    smooth = np.asarray(cv2.medianBlur(filled, 5), dtype=np.float32)
    gradient = np.hypot(
        cv2.Sobel(smooth, cv2.CV_32F, 1, 0, scale=0.125),
        cv2.Sobel(smooth, cv2.CV_32F, 0, 1, scale=0.125),
    ) / np.maximum(smooth, 0.1)
    shade = 230.0 / (1.0 + (gradient / _SLOPE) ** 2)
    return np.where(measured, np.clip(shade, 25.0, 230.0), 0.0).astype(np.uint8)


_BLAZEPOSE_SIDE = 2.5
"""Side of BlazePose's crop over the radius of the circle around the person: its diameter and a
margin of a quarter (``RectTransformationCalculator`` of MediaPipe's pose_landmark graph)."""

_AROUND_POINTS = 1.25  # side of a crop over the longer side of the box around a person
_BODY_RADIUS = 1.0  # metres from the hips to the circle that holds an adult's body
_LEAST_SIDE = 16.0  # side in pixels below which a crop shows nothing


@dataclass(frozen=True, eq=False)
class Crop:
    """A square part of a picture, perhaps turned."""

    centre: FloatArray  # (2,). Pixels of the picture.
    side: float  # pixels of the picture along the longer side of what the network sees
    angle: float = 0.0  # clockwise angle in the picture from its top to the crop's top, radians

    def model_from_picture(self, size: tuple[int, int]) -> FloatArray:
        """Affine map (2, 3) from the picture's pixels to those of an input of width and height
        `size`.
        """
        cos, sin = np.cos(self.angle), np.sin(self.angle)
        A = max(size) / self.side * np.array([[cos, sin], [-sin, cos]])
        middle = (np.array(size, dtype=np.float64) - 1.0) / 2.0
        return np.column_stack([A, middle - A @ self.centre])

    def seen(self, picture: ImageArray, size: tuple[int, int]) -> ImageArray:
        """The part as a picture of this size; black outside of the picture.

        A part that is shrunk by more than two is averaged first: bilinear interpolation alone would
        take single pixels, with their noise.
        """
        affine, shrunk = self.model_from_picture(size), picture
        if (step := int(self.side / max(size))) > 1:
            shrunk, affine = self._averaged(picture, affine, step)
        return np.asarray(
            cv2.warpAffine(shrunk, affine, size, flags=cv2.INTER_LINEAR), dtype=np.uint8
        )

    def _averaged(
        self, picture: ImageArray, affine: FloatArray, step: int
    ) -> tuple[ImageArray, FloatArray]:
        """The surroundings of the crop with means of `step` x `step` pixels, and their map."""
        reach = self.side * (abs(np.cos(self.angle)) + abs(np.sin(self.angle))) / 2.0 + step
        end = np.array(picture.shape[1::-1])
        low = np.clip(np.floor(self.centre - reach), 0, end).astype(int)
        high = np.clip(np.ceil(self.centre + reach), 0, end).astype(int)
        count = (high - low) // step
        if count.min() < 1:
            return picture, affine
        high = low + count * step
        part = picture[low[1] : high[1], low[0] : high[0]]
        shrunk = cv2.resize(part, count.tolist(), interpolation=cv2.INTER_AREA)
        A, b = affine[:, :2], affine[:, 2]
        first = low + (step - 1) / 2.0  # the centre of the first mean
        return np.asarray(shrunk, dtype=np.uint8), np.column_stack([step * A, A @ first + b])

    def in_picture(self, places: FloatArray, size: tuple[int, int]) -> FloatArray:
        """Pixels (..., 2) of the picture, of pixels of a network's input of this size."""
        affine = self.model_from_picture(size)
        A, b = affine[:, :2], affine[:, 2]
        return np.asarray((places - b) @ np.linalg.inv(A).T, dtype=np.float64)

    def mask_in_picture(self, mask: FloatArray, shape: tuple[int, int]) -> FloatArray:
        """A network's mask (h, w) as one of the whole picture (H, W); 0 outside of the crop."""
        height, width = shape
        inverse = cv2.WARP_INVERSE_MAP | cv2.INTER_LINEAR
        affine = self.model_from_picture((mask.shape[1], mask.shape[0]))
        return np.asarray(cv2.warpAffine(mask, affine, (width, height), flags=inverse))


def whole_picture(shape: tuple[int, ...], turned: int = 0) -> Crop:
    """Crop that shows all of a picture (H, W, ...), to be turned clockwise by degrees."""
    height, width = shape[:2]
    centre = np.array([width - 1.0, height - 1.0]) / 2.0
    return Crop(centre, float(max(height, width)), -np.radians(turned))


def crop_around(
    centre: FloatArray, reach: FloatArray, size: tuple[int, int], turned: int = 0
) -> Crop:
    """Crop that shows a box to a network with an input of this size.

    `centre` (2,) and `reach` (2,), width and height, are in pixels of the picture, which is turned
    clockwise by `turned` degrees, a multiple of 90, to be upright.
    """
    width, height = (reach[1], reach[0]) if turned % 180 else (reach[0], reach[1])
    scale = min(size[0] / max(width, 1.0), size[1] / max(height, 1.0))
    return Crop(np.asarray(centre), max(size) / scale, -np.radians(turned))


def crop_from_points(points: FloatArray, turned: int = 0) -> Crop:
    """Crop around points (N, 2) of a whole person, from head to feet; NaN are left out.

    A crop around the upper body alone misleads the landmark network: see :func:`crop_from_body`.
    """
    finite = points[np.isfinite(points).all(axis=1)]
    low, high = finite.min(axis=0), finite.max(axis=0)
    side = max(_AROUND_POINTS * float((high - low).max()), _LEAST_SIDE)
    return Crop((low + high) / 2.0, side, -np.radians(turned))


def crop_from_body(camera: Camera, hips: FloatArray, shoulders: FloatArray) -> Crop | None:
    """Crop around a body whose `hips` and `shoulders` have these middles (3,), world.

    None if the camera does not see its hips. Its size follows from the distance alone, so that a
    person who bends towards the camera is seen as well. On recordings with truth this crop is right
    more often than any found one.
    """
    (x0, y0), (x1, y1) = places = camera.project(np.stack([hips, shoulders]))
    depth = float(camera.camera_from_world.apply(hips)[2])
    if not np.isfinite(places[0]).all():
        return None
    up = np.array([0.0, -1.0])
    if np.hypot(x1 - x0, y1 - y0) > 0.0:  # false for NaN, behind the camera
        up = (places[1] - places[0]) / np.hypot(x1 - x0, y1 - y0)
    return crop_from_circle(places[0], places[0] + _BODY_RADIUS * camera.focal / depth * up)


def crop_from_circle(hips: FloatArray, top: FloatArray) -> Crop:
    """Crop as BlazePose expects it: the hips (2,) in the middle, the person upright, pixels.

    `top` (2,) is above the head on the circle around the hips that holds the whole body: about 1 m
    from the hips along the trunk.
    """
    x, y = top - hips
    side = max(_BLAZEPOSE_SIDE * float(np.hypot(x, y)), _LEAST_SIDE)
    return Crop(np.asarray(hips, dtype=np.float64), side, float(np.arctan2(x, -y)))
