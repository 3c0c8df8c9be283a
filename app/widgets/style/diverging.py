"""Colours from blue over a neutral one to orange, for numbers with a sign."""

from __future__ import annotations

import numpy as np
from PySide6.QtGui import QColor

from stereotrack_core.arrays import FloatArray, ImageArray, IntArray

from .theme import Theme

_LOW, _HIGH = (0x00, 0x72, 0xB2), (0xD5, 0x5E, 0x00)
_LOW_ON_DARK, _HIGH_ON_DARK = (0x3A, 0xA6, 0xF0), (0xFF, 0x8A, 0x2B)
_PALE = (0xD2, 0xD2, 0xD2)

FULL_RESIDUAL = 0.06
"""Metres at which a residual's colour is as strong as it gets."""

SHADES = 9
"""Shades that residuals are drawn in."""


def diverging_rgb(values: FloatArray, theme: Theme) -> ImageArray:
    """Colours (..., 3) of values from -1 to 1; what is not known is as the background."""
    base = QColor(theme.base)
    neutral = (base.red(), base.green(), base.blue())
    low, high = (_LOW_ON_DARK, _HIGH_ON_DARK) if theme.is_dark else (_LOW, _HIGH)
    return _mixed(np.nan_to_num(values), low, neutral, high)


def shade_colours() -> tuple[str, ...]:
    """Colours of residuals over pictures, from far inside the model to far outside of it."""
    places = np.linspace(-1.0, 1.0, SHADES)
    mixed = _mixed(places, _LOW_ON_DARK, _PALE, _HIGH_ON_DARK)
    return tuple("#{:02x}{:02x}{:02x}".format(*row) for row in mixed.tolist())


def shade_of(residual: FloatArray) -> IntArray:
    """Index (m,) into :func:`shade_colours` of residuals in metres."""
    share = np.clip(residual / FULL_RESIDUAL, -1.0, 1.0)
    return np.round((share + 1.0) * 0.5 * (SHADES - 1)).astype(np.int64)


def _mixed(
    values: FloatArray, low: tuple[int, ...], neutral: tuple[int, ...], high: tuple[int, ...]
) -> ImageArray:
    share = np.clip(values, -1.0, 1.0)[..., None]
    towards = np.where(share < 0, np.array(low), np.array(high))
    mixed = np.array(neutral) + np.abs(share) * (towards - np.array(neutral))
    result: ImageArray = np.round(mixed).astype(np.uint8)
    return result
