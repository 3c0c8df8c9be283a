"""Pictures as arrays: numbered image files, such as ``N/%06d.png``, and decoded video frames.

Grey values are those of ffmpeg's conversion to ``gray`` and of OpenCV's: limited range (luma 16
to 235, which is what a stream without a statement means) is stretched to 0 to 255, full range
stays. The luma plane is taken as it is and stretched, without colour conversion.
"""

import re
from collections.abc import Callable, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from stereotrack_core.arrays import Float32Array, ImageArray
from stereotrack_core.errors import InputError
from stereotrack_core.reading import PICTURE_BYTES, read_bytes

Keep: TypeAlias = Callable[[int, NDArray[Any]], None]
"""Is given the number and the pixels of every picture that decoding yields on the way."""


class DamagedFrame(Exception):
    """A single frame cannot be decoded; the text says why, as a clause."""


PictureKind: TypeAlias = Literal["grey", "colour", "depth", "stored"]
"""``stored`` keeps the 16 bits of brightness that grey and colour reduce to 8."""

_FULL_RANGE = 2  # AVCOL_RANGE_JPEG
_BLACK, _STRETCH = 16, 255 / 219  # luma that becomes 0 in limited range, and grey levels per luma
_PLANAR_LUMA = ("yuv", "yuvj", "nv12", "nv21", "gray")


def picture_of(frame: Any, kind: PictureKind) -> NDArray[Any]:
    """Pixels of a decoded frame, read-only.

    (H, W) uint8 for grey; (H, W, 3) uint8 BGR for colour, but (H, W) where the stream itself is
    grey; (H, W) uint16 for depth. Raises :class:`DamagedFrame` when depth is wanted of pictures
    with less than 16 bits.
    """
    sixteen_bit = frame.format.name.startswith("gray16")
    if kind == "depth" or (kind == "stored" and sixteen_bit):
        if not sixteen_bit:
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
    if not name.startswith(_PLANAR_LUMA) or not eight_bit:
        return np.asarray(frame.to_ndarray(format="gray"))
    plane = frame.planes[0]
    rows = np.frombuffer(plane, dtype=np.uint8).reshape(-1, plane.line_size)
    luma = rows[: frame.height, : frame.width]
    if name.startswith(("yuvj", "gray")) or frame.color_range == _FULL_RANGE:
        return luma.copy()
    # Gives ffmpeg's value for each of the 256, in a third of the time of a table.
    stretched = cv2.addWeighted(luma, _STRETCH, luma, 0.0, -_BLACK * _STRETCH)
    return np.asarray(stretched, dtype=np.uint8)


_NUMBER = re.compile(r"%(0(\d+))?d")

_PNG = b"\x89PNG\r\n\x1a\n"

_WIDEST = 18  # digits of the longest number in a file's name
_READ_FLAGS: dict[PictureKind, int] = {
    # Turning a picture by its EXIF entry would part it from its calibration.
    "grey": cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION,
    "colour": cv2.IMREAD_ANYCOLOR | cv2.IMREAD_IGNORE_ORIENTATION,
    "stored": cv2.IMREAD_ANYDEPTH | cv2.IMREAD_ANYCOLOR | cv2.IMREAD_IGNORE_ORIENTATION,
    "depth": cv2.IMREAD_UNCHANGED,
}


def is_pattern(frames: str) -> bool:
    """Whether `frames` names numbered images rather than a video."""
    return "%" in frames


def numbered_files(folder: Path, pattern: str) -> dict[int, Path]:
    """Files that fit a printf pattern in the last part of its path, by number. ValueError if it has
    not exactly one ``%d`` or ``%0Nd`` there, OSError if the folder cannot be read.
    """
    path = folder / pattern
    places = list(_NUMBER.finditer(path.name))
    if len(places) != 1 or "%" in _NUMBER.sub("", path.name) or "%" in str(path.parent):
        raise ValueError(pattern)
    place = places[0]
    width = int(place.group(2) or 1)
    if width > _WIDEST:
        raise ValueError(pattern)
    before, after = path.name[: place.start()], path.name[place.end() :]
    number = rf"(\d{{{width},{_WIDEST}}})"
    fitting = re.compile(re.escape(before) + number + re.escape(after))
    found = {}
    for file in path.parent.iterdir():
        match = fitting.fullmatch(file.name)
        if match and (len(match.group(1)) == width or match.group(1)[0] != "0"):
            found[int(match.group(1))] = file
    return found


def read_image(path: Path, kind: PictureKind) -> NDArray[Any]:
    """Pixels of an image file, read-only, not turned.

    (H, W) uint8 for grey; (H, W, 3) uint8 BGR or (H, W) for colour; (H, W) uint16 (or the file's
    own type) for depth; uint8 or uint16 as for colour if stored. Raises :class:`DamagedFrame` when
    the file is missing or no image.
    """
    try:
        content = read_bytes(path, PICTURE_BYTES)
    except InputError as refusal:
        raise DamagedFrame(f"{path.name}: {refusal.what}") from None
    picture = decoded(content, _READ_FLAGS[kind])
    if picture is None:
        raise DamagedFrame(f"the file {path.name} is damaged or not an image")
    if kind == "depth" and (picture.ndim != 2 or picture.dtype not in (np.uint16, np.uint8)):
        raise DamagedFrame(f"the file {path.name} is not a 16-bit depth map with one channel")
    if kind == "stored" and picture.dtype not in (np.uint16, np.uint8):
        raise DamagedFrame(f"the file {path.name} has no values of 8 or 16 bits")
    picture.flags.writeable = False
    return picture


def read_metres(path: Path) -> NDArray[np.float32]:
    """A depth map (H, W) of floating-point metres; DamagedFrame where a file is none."""
    try:
        picture = decoded(read_bytes(path, PICTURE_BYTES), cv2.IMREAD_UNCHANGED)
    except InputError:
        picture = None
    if picture is None or picture.dtype != np.float32 or picture.ndim != 2:
        raise DamagedFrame(f"the file {path.name} is no depth map of 32-bit floats")
    return picture


def counts_of(metres: Float32Array, unit: float) -> NDArray[np.uint16]:
    """Depth counts (H, W) of metres; 0 where it is NaN or more than 16 bits hold."""
    counts = np.round(np.nan_to_num(metres, nan=0.0, posinf=0.0, neginf=0.0) / unit)
    counts[(counts < 0) | (counts > np.iinfo(np.uint16).max)] = 0
    return counts.astype(np.uint16)


def decoded(content: bytes, flags: int) -> NDArray[Any] | None:
    """Pixels of an image of any format, by OpenCV's flags; None where it is damaged or none."""
    if not content or _is_cut_off(content):
        return None
    try:
        return cv2.imdecode(np.frombuffer(content, dtype=np.uint8), flags)
    except cv2.error:
        return None


def _is_cut_off(content: bytes) -> bool:
    """Whether one of the parts of a PNG claims to be longer than the file, or its end is missing.

    OpenCV makes room for a part before it reads it: gigabytes for a file of some hundred bytes.
    """
    if not content.startswith(_PNG):
        return False
    at = len(_PNG)
    while content[at + 4 : at + 8] not in (b"IEND", b""):
        at += 12 + int.from_bytes(content[at : at + 4])  # length, kind, content, checksum
    return not content.startswith(b"\0\0\0\0IEND", at)


WHITEST = 65535  # the largest value of 16 bits
LARGEST_VALUES = (255, 1023, 4095, 16383, WHITEST)  # of sensors of 8, 10, 12, 14 and 16 bits
MEASURED_PICTURES = 32  # pictures, spread over a stream, by which the white of 16 bits is found
_HIGHLIGHTS = 0.001  # of the pixels, that may be brighter than white: lamps and reflections


def white_of(counts: NDArray[np.int64], stated: int | None = None) -> int:
    """Value that becomes white, by counts (65536,) of 16-bit values: the largest `stated` unless
    pictures exceed it, else the smallest of a sensor that they stay below.
    """
    candidates = LARGEST_VALUES if stated is None else (stated, *LARGEST_VALUES)
    most = _HIGHLIGHTS * counts.sum()
    return next(one for one in candidates if one == WHITEST or counts[one + 1 :].sum() <= most)


def brightness_of(values: NDArray[Any], white: int) -> ImageArray:
    """Brightness of 16 bits (H, W) or (H, W, 3) as 8 bits; what exceeds white becomes white."""
    share = values.astype(np.float32) / white
    return np.asarray(np.round(255.0 * np.minimum(share, 1.0)), dtype=np.uint8)


def spread(count: int, most: int) -> list[int]:
    """Numbers of at most so many of `count` frames, evenly spread."""
    numbers: list[int] = np.unique(np.linspace(0, count - 1, most).astype(int)).tolist()
    return numbers if count else []


class NumberedImages:
    """Image files of a pattern by number, from the lowest one; a gap is a damaged frame.

    Brightness of 16 bits is reduced to 8 alike in all of them; with a `unit` in metres, depth maps
    of floating-point metres are given as counts.
    """

    def __init__(
        self, files: Mapping[int, Path], pattern: str, kind: PictureKind, unit: float | None = None
    ) -> None:
        self._files, self._unit = files, unit
        self._lowest = min(files)
        self._count = max(files) - self._lowest + 1
        self._pattern = pattern
        self._kind: PictureKind = kind

    def count(self) -> int:
        """Number of frames, gaps included."""
        return self._count

    def count_so_far(self) -> tuple[int, bool]:
        """Number of frames; final."""
        return self._count, True

    def missing(self) -> tuple[int, ...]:
        """File numbers that are absent between the first and the last."""
        numbers = range(self._lowest, self._lowest + self._count)
        return tuple(n for n in numbers if n not in self._files)

    def read(self, k: int, keep: Keep) -> NDArray[Any]:  # noqa: ARG002 - nothing is on the way
        """Picture of frame k."""
        file = self._files.get(self._lowest + k)
        if file is None:
            missing = _NUMBER.sub(lambda _: "%d", self._pattern) % (self._lowest + k)
            raise DamagedFrame(f"file number {self._lowest + k} is missing ({missing})")
        if self._unit is not None:
            return counts_of(read_metres(file), self._unit)
        if self._kind in ("grey", "colour") and self._white:
            picture = brightness_of(read_image(file, "stored"), self._white)
            in_colour = self._kind == "grey" and picture.ndim == 3
            return cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY) if in_colour else picture
        return read_image(file, self._kind)

    @cached_property
    def _white(self) -> int:
        """Value that becomes white in pictures of 16 bits; 0 if they have 8."""
        counts = np.zeros(WHITEST + 1, dtype=np.int64)
        numbers = sorted(self._files)
        for at in spread(len(numbers), MEASURED_PICTURES):
            try:
                picture = read_image(self._files[numbers[at]], "stored")
            except DamagedFrame:
                continue
            if picture.dtype != np.uint16:
                return 0
            counts += np.bincount(picture.ravel(), minlength=WHITEST + 1)
        return white_of(counts) if counts.any() else 0

    def close(self) -> None:
        """Nothing is held open."""
