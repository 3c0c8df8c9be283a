"""Pictures in messages of ROS: sensor_msgs/Image and sensor_msgs/CompressedImage."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from stereotrack_core.recording.images import DamagedFrame, PictureKind, decoded
from stereotrack_core.recording.writing import counts_of

METRIC_UNIT = 0.0005
"""Metres per count of depth maps that were floating-point metres: up to 32 m."""

_TO_BGR: Mapping[str, int | None] = {
    "bgr8": None, "8UC3": None, "rgb8": cv2.COLOR_RGB2BGR,
    "rgba8": cv2.COLOR_RGBA2BGR, "bgra8": cv2.COLOR_BGRA2BGR, "8UC4": cv2.COLOR_BGRA2BGR,
    "bayer_rggb8": cv2.COLOR_BayerRGGB2BGR, "bayer_bggr8": cv2.COLOR_BayerBGGR2BGR,
    "bayer_gbrg8": cv2.COLOR_BayerGBRG2BGR, "bayer_grbg8": cv2.COLOR_BayerGRBG2BGR,
    "yuv422": cv2.COLOR_YUV2BGR_UYVY, "uyvy": cv2.COLOR_YUV2BGR_UYVY,
    "yuv422_yuy2": cv2.COLOR_YUV2BGR_YUY2, "yuyv": cv2.COLOR_YUV2BGR_YUY2,
}  # fmt: skip
_CHANNELS: Mapping[str, int] = {
    "bgr8": 3, "rgb8": 3, "8UC3": 3, "rgba8": 4, "bgra8": 4, "8UC4": 4,
    "yuv422": 2, "uyvy": 2, "yuv422_yuy2": 2, "yuyv": 2,
}  # fmt: skip
_GREY = frozenset({"mono8", "8UC1"})
_COUNTS = frozenset({"16UC1", "mono16"})
_HEADER = struct.Struct("<iff")  # of compressedDepth: format, and the quantisation of floats


def is_depth(message: Any) -> bool:
    """Whether an image holds 16-bit counts or metres."""
    if hasattr(message, "encoding"):
        return message.encoding in _COUNTS or message.encoding == "32FC1"
    words = str(message.format)
    return "compressedDepth" in words or "16UC1" in words or "mono16" in words


def picture_in(message: Any, kind: PictureKind, unit: float) -> NDArray[Any]:
    """Pixels of a message: (H, W) uint8 grey, (H, W, 3) BGR uint8, or (H, W) uint16 counts.

    Stored: uint8 or uint16 as in the message. Metres become counts of `unit`. Raises
    DamagedFrame where they cannot be decoded.
    """
    try:
        raw = _raw(message) if hasattr(message, "encoding") else _compressed(message)
    except (cv2.error, ValueError, struct.error) as error:
        raise DamagedFrame(f"the image cannot be decoded ({error})") from None
    if raw.dtype == np.float32:
        raw = counts_of(raw, unit)
    if kind == "depth":
        if raw.dtype != np.uint16 or raw.ndim != 2:
            raise DamagedFrame("the image holds no depth; 16 bits or floats are needed")
        return raw
    if kind == "stored":
        return raw
    if raw.dtype == np.uint16:  # whose white is not known here
        raw = (raw >> 8).astype(np.uint8)
    if kind == "grey" and raw.ndim == 3:
        return np.asarray(cv2.cvtColor(raw, cv2.COLOR_BGR2GRAY))
    return raw


def _raw(message: Any) -> NDArray[Any]:
    encoding, height, width = str(message.encoding), int(message.height), int(message.width)
    if encoding in _COUNTS or encoding == "32FC1":
        order = ">" if message.is_bigendian else "<"
        kind = np.dtype(f"{order}f4" if encoding == "32FC1" else f"{order}u2")
        values = _rows(message, width * kind.itemsize).view(kind)
        return values.astype(kind.newbyteorder("="))
    base = f"{encoding[:-2]}8" if encoding.endswith("16") else encoding
    if base not in _TO_BGR and base not in _GREY:
        raise DamagedFrame(
            f"images of encoding {encoding!r} cannot be read; use mono8, mono16, rgb8, bgr8, bayer,"
            " yuv422, 16UC1 or 32FC1"
        )
    channels = _CHANNELS.get(base, 1)
    rows = _rows(message, width * channels * (1 if base == encoding else 2))
    if base != encoding:
        kind = np.dtype(">u2" if message.is_bigendian else "<u2")
        rows = rows.view(kind).astype(np.uint16)
    code = _TO_BGR.get(base)
    pixels = rows if channels == 1 else rows.reshape(height, width, channels)
    return pixels if code is None else np.asarray(cv2.cvtColor(pixels, code))


def _rows(message: Any, wanted: int) -> NDArray[Any]:
    """Bytes (H, wanted) of the pixels, without what fills the rows up."""
    data = np.asarray(message.data, dtype=np.uint8)
    height, step = int(message.height), int(message.step)
    if height < 1 or step < wanted or data.size < height * step:
        raise DamagedFrame("the image has fewer bytes than its size needs")
    return np.ascontiguousarray(data[: height * step].reshape(height, step)[:, :wanted])


def _compressed(message: Any) -> NDArray[Any]:
    data = np.asarray(message.data, dtype=np.uint8)
    if "compressedDepth" not in str(message.format):
        flags = cv2.IMREAD_ANYCOLOR | cv2.IMREAD_ANYDEPTH
        flags = cv2.IMREAD_UNCHANGED if is_depth(message) else flags
        return _decoded(data, flags | cv2.IMREAD_IGNORE_ORIENTATION)
    if data.size <= _HEADER.size:
        raise DamagedFrame("the compressed depth map is cut off")
    counts = _decoded(data[_HEADER.size :], cv2.IMREAD_UNCHANGED)
    if "32FC1" not in str(message.format):
        return counts
    _, a, b = _HEADER.unpack_from(data.tobytes())  # inverse depth: metres = a / (count - b)
    known = counts > 0
    metres = np.zeros(counts.shape, np.float32)
    metres[known] = a / (counts[known].astype(np.float32) - np.float32(b))
    return metres


def _decoded(data: NDArray[np.uint8], flags: int) -> NDArray[Any]:
    picture = decoded(data.tobytes(), flags)
    if picture is None:
        raise DamagedFrame("the compressed image is damaged")
    return picture
