"""Lanes as pixels: every strip is computed for all its columns at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stereotrack_core.arrays import FloatArray, ImageArray

from ..style.theme import Theme
from .lanes import Lane, Mark, covered_columns


def strip_pixels(lane: Lane, edges: FloatArray, height: int, theme: Theme) -> ImageArray:
    """Picture of a lane.

    Parameters
    ----------
    lane : Lane
    edges : (C + 1,) float64
        Frames at the borders of the columns of pixels.
    height : int, pixels
    theme : Theme

    Returns
    -------
    (height, C, 4) uint8, RGBA
    """
    pixels = np.empty((height, len(edges) - 1, 4), dtype=np.uint8)
    pixels[:] = rgba(theme.base)
    has_values = len(lane.values) > 0
    if lane.kind == "bars":
        _paint_bars(pixels, lane, edges)
    elif lane.kind == "marks" and has_values:
        _paint_marks(pixels, lane, edges, theme)
    elif has_values:
        _paint_heat(pixels, lane, edges, theme)
    return pixels


def heat_colours(values: FloatArray, full: float, colour: str, theme: Theme) -> ImageArray:
    """Colours (C, 4) of values: from the background over the limb's colour to the text's.

    The lightness runs one way, so that the order is seen without telling hues apart. NaN is
    left transparent.
    """
    stops = np.array([rgba(theme.base), rgba(colour), rgba(theme.text)], dtype=np.float64)
    share = np.clip(np.nan_to_num(values) / full, 0.0, 1.0)
    # the limb's own colour stands at two thirds, the last third warns
    places = np.array([0.0, 0.66, 1.0])
    result = np.stack([np.interp(share, places, stops[:, k]) for k in range(4)], axis=1)
    result[np.isnan(values)] = (0, 0, 0, 0)
    colours: ImageArray = result.astype(np.uint8)
    return colours


def rgba(colour: str) -> NDArray[np.uint8]:
    """Red, green, blue and full opacity (4,) of #rrggbb."""
    return np.array([*bytes.fromhex(colour[1:]), 255], dtype=np.uint8)


def _paint_heat(pixels: ImageArray, lane: Lane, edges: FloatArray, theme: Theme) -> None:
    values = np.asarray(lane.summary.columns(edges), dtype=np.float64)
    known = ~np.isnan(values)
    colours = heat_colours(values, lane.full_value, lane.colour, theme)
    pixels[1:-1, known] = colours[known]
    _hatch(pixels, ~known, theme)


def _hatch(pixels: ImageArray, columns: NDArray[np.bool_], theme: Theme) -> None:
    # what is not known is not zero: a thin line in the middle instead of an empty strip
    middle = pixels.shape[0] // 2
    dots = columns & (np.arange(pixels.shape[1]) % 4 < 2)
    pixels[middle, dots] = rgba(theme.disabled)


def _paint_marks(pixels: ImageArray, lane: Lane, edges: FloatArray, theme: Theme) -> None:
    bits = np.asarray(lane.summary.columns(edges), dtype=np.uint8)
    height = pixels.shape[0]
    middle = height // 2
    half = max(1, height // 12)

    def has(mark: Mark) -> NDArray[np.bool_]:
        return (bits & (1 << mark)) > 0

    # a pixel as one number: painting it is several times as fast as painting four
    whole = pixels.view(np.uint32)[..., 0]
    colour = _number(lane.colour)
    _stripe(whole, has(Mark.GAP), theme)
    whole[middle - half : middle + half, has(Mark.INTERPOLATED)] = colour
    whole[middle:-1, _widened(has(Mark.PARTLY), edges)] = colour
    whole[-max(2, height // 6) :, has(Mark.MISSING)] = _number(theme.error)
    flagged = _widened(has(Mark.FLAGGED), edges)
    whole[1:-1, _widened(has(Mark.CLICKED), edges) | flagged] = colour
    whole[: max(3, height // 3), flagged] = _number(theme.warning)


def _number(colour: str) -> np.uint32:
    number: np.uint32 = rgba(colour).view(np.uint32)[0]
    return number


def _stripe(whole: NDArray[np.uint32], columns: NDArray[np.bool_], theme: Theme) -> None:
    # slanted lines over the whole height: on purpose nothing
    if not columns.any():
        return
    rows, places = np.indices(whole.shape)
    inside = (rows > 0) & (rows < whole.shape[0] - 1)
    whole[((rows + places) % 6 < 2) & inside & columns] = _number(theme.disabled)


def _widened(columns: NDArray[np.bool_], edges: FloatArray) -> NDArray[np.bool_]:
    # one click among many frames has to be seen: two pixels at least
    per_column = (edges[-1] - edges[0]) / max(len(edges) - 1, 1)
    if per_column < 0.5:
        return columns
    result = columns.copy()
    result[1:] |= columns[:-1]
    return result


def _paint_bars(pixels: ImageArray, lane: Lane, edges: FloatArray) -> None:
    covered = covered_columns(lane.spans, edges)
    inset = max(1, pixels.shape[0] // 8)
    pixels[inset:-inset, covered] = rgba(lane.colour)
