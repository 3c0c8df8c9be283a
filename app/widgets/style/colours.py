"""Colours of limbs, line styles of runs, and colours of numbers, the same everywhere."""

from types import MappingProxyType
from typing import Literal, TypeAlias

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtGui import QPainter, QPen, QPixmap

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.evaluation.limbs import LIMB_COLOURS

from .theme import drawn_pixmap

Emphasis: TypeAlias = Literal["usual", "front", "behind"]
"""Whether curves stand out before others, which then step back."""
LineStyle: TypeAlias = Literal["solid", "dash", "dot", "dashdot", "reference"]

PEN_STYLES: dict[LineStyle, Qt.PenStyle] = {
    "solid": Qt.PenStyle.SolidLine,
    "dash": Qt.PenStyle.DashLine,
    "dot": Qt.PenStyle.DotLine,
    "dashdot": Qt.PenStyle.DashDotLine,
    "reference": Qt.PenStyle.DashDotDotLine,
}
"""No run has the style of the reference."""

OLD = 0.4  # opacity of what was fitted before the last click


def line_pixmap(pen: QPen, ratio: float) -> QPixmap:
    """A piece of line, 28 x 14 pixels."""

    def draw(painter: QPainter) -> None:
        painter.setPen(pen)
        painter.drawLine(2, 7, 26, 7)

    return drawn_pixmap(28, 14, draw, ratio)


_LOW_ON_DARK, _HIGH_ON_DARK = (0x3A, 0xA6, 0xF0), (0xFF, 0x8A, 0x2B)
_PALE = (0xD2, 0xD2, 0xD2)

FULL_RESIDUAL = 0.06  # metres at which a residual's colour is as strong as it gets
SHADES = 9  # shades that residuals are drawn in


def shade_colours() -> tuple[str, ...]:
    """Colours of residuals over pictures, from far inside the model to far outside of it."""
    places = np.linspace(-1.0, 1.0, SHADES)
    stops = zip(_LOW_ON_DARK, _PALE, _HIGH_ON_DARK, strict=True)
    mixed = np.stack([np.interp(places, (-1.0, 0.0, 1.0), one) for one in stops], axis=1)
    return tuple("#" + bytes(row).hex() for row in np.round(mixed).astype(np.uint8))


def shade_of(residual: FloatArray) -> IntArray:
    """Index (m,) into :func:`shade_colours` of residuals in metres."""
    share = np.clip(residual / FULL_RESIDUAL, -1.0, 1.0)
    return np.round((share + 1.0) * 0.5 * (SHADES - 1)).astype(np.int64)


__all__ = ["EXTRA_COLOURS", "LANDMARK_LIMBS", "LIMB_COLOURS", "limb_words"]

EXTRA_COLOURS: MappingProxyType[str, str] = MappingProxyType({"unexplained %": "#CC79A7"})
"""Curves that are no angle of a limb and are drawn when asked for."""

LANDMARK_LIMBS: MappingProxyType[str, str] = MappingProxyType(
    {
        "left_shoulder": "left_upper_arm",
        "right_shoulder": "right_upper_arm",
        "left_elbow": "left_upper_arm",
        "right_elbow": "right_upper_arm",
        "left_hand": "left_forearm",
        "right_hand": "right_forearm",
        "head": "head",
        "left_hip": "torso",
        "right_hip": "torso",
    }
)
"""The limb whose colour a landmark is drawn in."""


def brief_limb_words(limb: str) -> str:
    """Return the limb's name for where there is little room, such as ``L upper arm``."""
    brief = limb_words(limb).replace("left ", "L ").replace("right ", "R ")
    return brief.replace("unexplained", "unexpl.")


def limb_words(limb: str) -> str:
    """Return the limb's name as a person reads it, such as ``left upper arm``."""
    return limb.replace("_", " ")
