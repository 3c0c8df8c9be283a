"""Text on pictures, in the letters that matplotlib brings along."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import matplotlib
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from stereotrack_core.arrays import ImageArray


def text_width(text: str, size: float, *, bold: bool = False) -> float:
    """Width in pixels of a line of text whose letters are `size` pixels high."""
    return float(_font(size, bold).getlength(text))


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
    drawn = Image.fromarray(picture)
    pen = ImageDraw.Draw(drawn)
    anchor = "ms" if middle else "ls"
    pen.text(place, text, font=_font(size, bold), fill=colour, anchor=anchor)
    picture[:] = np.asarray(drawn)


@cache
def _font(size: float, bold: bool) -> ImageFont.FreeTypeFont:
    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    place = Path(matplotlib.get_data_path()) / "fonts" / "ttf" / name
    return ImageFont.truetype(place, size, layout_engine=ImageFont.Layout.BASIC)
