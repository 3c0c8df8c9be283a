"""Colours of points, as the views' pictures show them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import cv2
import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.depth.cloud import ViewDepth


def colours_of(
    views: Sequence[str], depths: Mapping[str, ViewDepth], view: IntArray, pixels: IntArray
) -> FloatArray | None:
    """Colours (N, 3) at pixels (N, 2) of views (N,), BGR from 0 to 255, over 3 x 3 pixels.

    None without any coloured picture. Cameras whose colours differ are not matched to each other:
    their gains differ by up to 14 %, a shirt and an arm by much more.
    """
    pictures = {name: d.picture for name, d in depths.items() if d.picture is not None}
    if not pictures:
        return None
    colours = np.full((len(view), 3), np.nan)
    for name, picture in pictures.items():
        u, v = pixels[of_view := view == views.index(name)].T
        colours[of_view] = cv2.blur(picture, (3, 3))[v, u]
    return colours
