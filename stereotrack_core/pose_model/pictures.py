"""RGB pictures for networks that learned from photographs."""

from typing import TypeGuard

import cv2
import numpy as np

from stereotrack_core.arrays import Float32Array, ImageArray

_EVERY = 4  # only every so many columns and rows are looked at for the brightness

_DARK = 120.0
"""Grey value that the brightest hundredth of a picture at least has if it is left as it is."""

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
