"""By how many rows the left images of a stereo pair lie too low.

A lens that was touched or a rolling shutter leaves a pair whose rows differ by less than a pixel.
Block matching still works then, and yet arms become half as inaccurate again.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import cv2
import numpy as np

from stereotrack_core.arrays import ImageArray
from stereotrack_core.depth.light import shift_of
from stereotrack_core.depth.match import Region

if TYPE_CHECKING:
    from stereotrack_core.depth.sources import StereoFrame

_STEPS = 3
"""Steps of least squares; each finds two thirds of what is left."""

_LEAST, _MOST = 0.2, 2.5
"""Rows that are worth a resampling (sound pairs have up to 0.02), and of which nothing is known as
blocks are no longer matched."""

_FEW = 0.2
"""Share of the image that has to be matched."""

_AROUND = (31, 31)
"""Neighbourhood, pixels, over which both pictures are brought to one brightness."""


def row_offset(opened: Callable[[float], StereoFrame]) -> float:
    """Pixels, in tenths, by which a pair's left image lies too low; 0 where it hardly does.

    Parameters
    ----------
    opened : callable
        Gives the pair whose left image was moved up by so many rows.
    """
    offset = 0.0
    for _ in range(_STEPS):
        frame = opened(offset)
        height, width = frame.picture.shape
        disparity = frame.disparity(Region.whole(width, height))
        matched = np.isfinite(disparity)
        if np.mean(matched) < _FEW:
            return 0.0
        rows, columns = np.mgrid[:height, :width].astype(np.float32)
        there = cv2.remap(
            frame.left, columns + np.where(matched, disparity, 0), rows, cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REPLICATE,
        ).astype(np.uint8, copy=False)  # fmt: skip
        step = shift_of(_at_brightness_of(frame.picture, there), frame.picture, matched)[1]
        offset += step
        if abs(step) < _LEAST / 4:
            break
    return round(offset, 1) if _LEAST < abs(offset) < _MOST else 0.0


def _at_brightness_of(picture: ImageArray, other: ImageArray) -> ImageArray:
    """The other picture at the local brightness of a picture."""
    a, b = (cv2.blur(one.astype(np.float32), _AROUND) for one in (picture, other))
    return np.asarray(np.clip(other * ((a + 1) / (b + 1)), 0, 255), dtype=np.uint8)
