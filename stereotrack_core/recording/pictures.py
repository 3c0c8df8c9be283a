"""Decoded video frames as arrays.

Grey values are those of ffmpeg's conversion to ``gray`` and of OpenCV's: limited range (luma 16
to 235, which is what a stream without a statement means) is stretched to 0 to 255, full range
stays. The luma plane is taken as it is and stretched by a table, without colour conversion.
"""

from __future__ import annotations

from functools import cache
from typing import Any, Literal, TypeAlias

import av
import cv2
import numpy as np
from numpy.typing import NDArray

from stereotrack_core.arrays import ImageArray
from stereotrack_core.recording.stream_source import DamagedFrame

PictureKind: TypeAlias = Literal["grey", "colour", "depth"]

FULL_RANGE = 2
"""AVCOL_RANGE_JPEG"""

PLANAR_LUMA = ("yuv", "yuvj", "nv12", "nv21", "gray")


def picture_of(frame: Any, kind: PictureKind) -> NDArray[Any]:
    """Pixels of a decoded frame, read-only.

    Parameters
    ----------
    frame : av.VideoFrame
    kind : {"grey", "colour", "depth"}

    Returns
    -------
    (H, W) uint8 for grey; (H, W, 3) uint8 BGR for colour, but (H, W) where the stream itself
    is grey; (H, W) uint16 for depth.

    Raises
    ------
    DamagedFrame
        When depth is wanted of pictures with less than 16 bits.
    """
    if kind == "depth":
        if not frame.format.name.startswith("gray16"):
            raise DamagedFrame(
                f"{frame.format.name} images contain no depth; 16-bit grey is needed"
            )
        picture = frame.to_ndarray(format="gray16le")
    elif kind == "grey" or frame.format.name.startswith("gray"):
        picture = _grey(frame)
    else:
        picture = frame.to_ndarray(format="bgr24")
    picture.flags.writeable = False
    return picture  # type: ignore[no-any-return]


def _grey(frame: Any) -> ImageArray:
    name = frame.format.name
    eight_bit = all(component.bits == 8 for component in frame.format.components)
    if not name.startswith(PLANAR_LUMA) or not eight_bit:
        converted: ImageArray = frame.to_ndarray(format="gray")
        return converted
    plane = frame.planes[0]
    rows = np.frombuffer(plane, dtype=np.uint8).reshape(-1, plane.line_size)
    luma = rows[: frame.height, : frame.width]
    if name.startswith(("yuvj", "gray")) or frame.color_range == FULL_RANGE:
        return luma.copy()
    stretched = cv2.LUT(luma, _stretch_table())
    return np.asarray(stretched, dtype=np.uint8)


@cache
def _stretch_table() -> ImageArray:
    """What ffmpeg makes of each limited-range luma: (y - 16) 255 / 219, in its own rounding."""
    planes = np.full((3, 256), 128, dtype=np.uint8)
    planes[:2] = np.arange(256, dtype=np.uint8)
    frame = av.VideoFrame.from_ndarray(planes, format="yuv420p")
    table: ImageArray = frame.to_ndarray(format="gray")[0].copy()
    return table
