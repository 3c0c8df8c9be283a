"""Text on pictures, in the letters that matplotlib brings along."""

from __future__ import annotations

import math

import cv2
import numpy as np
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import TextPath

from stereotrack_core.arrays import ImageArray

_FINE = 4
"""Letters are drawn so many times as large and made smaller, for smooth edges."""


def text_width(text: str, size: float, *, bold: bool = False) -> float:
    """Width in pixels of a line of text whose letters are `size` pixels high."""
    return float(_path(text, size, bold).get_extents().x1) if text.strip() else 0.0


def write(
    picture: ImageArray,
    text: str,
    place: tuple[float, float],
    size: float,
    colour: tuple[int, int, int] = (20, 20, 20),
    *,
    bold: bool = False,
    middle: bool = False,
) -> None:
    """Write a line of text into a picture, in place.

    Parameters
    ----------
    picture : (H, W, 3) uint8, BGR
    text : str
    place : (float, float), pixels
        Where the line begins, on its base line; its middle where `middle` is set.
    size : float, pixels
    colour : (int, int, int)
        Blue, green, red.
    bold, middle : bool
    """
    if not text.strip():
        return
    width = text_width(text, size, bold=bold)
    left = place[0] - (0.5 * width if middle else 0.0)
    corner = math.floor(left), math.floor(place[1] - 1.2 * size)
    fine = np.zeros((_FINE * math.ceil(1.8 * size), _FINE * (math.ceil(width) + 3)), dtype=np.uint8)
    polygons = [
        _FINE * (np.asarray(polygon) * (1.0, -1.0) + (left - corner[0], place[1] - corner[1]))
        for polygon in _path(text, size, bold).to_polygons()
    ]
    cv2.fillPoly(fine, [np.round(polygon).astype(np.int32) for polygon in polygons], 255)
    height, across = fine.shape[0] // _FINE, fine.shape[1] // _FINE
    ink = fine.reshape(height, _FINE, across, _FINE).mean(axis=(1, 3)) / 255.0
    top, start = max(corner[1], 0), max(corner[0], 0)
    shown = picture[top : corner[1] + height, start : corner[0] + across]
    part = ink[top - corner[1] :, start - corner[0] :][: shown.shape[0], : shown.shape[1], None]
    shown[:] = np.round((1.0 - part) * shown + part * np.array(colour)).astype(np.uint8)


def _path(text: str, size: float, bold: bool) -> TextPath:
    letters = FontProperties(family="DejaVu Sans", weight="bold" if bold else "normal", size=size)
    literally = text.replace("$", r"\$")  # or it would begin a formula
    return TextPath((0.0, 0.0), literally, prop=letters)
