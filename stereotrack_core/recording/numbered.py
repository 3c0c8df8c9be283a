"""Frames of a set of numbered image files, such as ``N/%06d.png``."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from stereotrack_core.errors import InputError
from stereotrack_core.reading import PICTURE_BYTES, read_bytes
from stereotrack_core.recording.pictures import PictureKind
from stereotrack_core.recording.stream_source import DamagedFrame, Keep

NUMBER = re.compile(r"%(0(\d+))?d")

_PNG = b"\x89PNG\r\n\x1a\n"

WIDEST = 18
"""Digits of the longest number in a file's name."""

READ_FLAGS: dict[PictureKind, int] = {
    # Turning a picture by its EXIF entry would part it from its calibration.
    "grey": cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION,
    "colour": cv2.IMREAD_ANYCOLOR | cv2.IMREAD_IGNORE_ORIENTATION,
    "depth": cv2.IMREAD_UNCHANGED,
}


def is_pattern(frames: str) -> bool:
    """Whether `frames` names numbered images rather than a video."""
    return "%" in frames


def numbered_files(folder: Path, pattern: str) -> dict[int, Path]:
    """Files that fit a printf pattern in the last part of its path, by number.

    Raises
    ------
    ValueError
        When the pattern has not exactly one ``%d`` or ``%0Nd`` in its last part.
    OSError
        When the folder cannot be read.
    """
    path = folder / pattern
    places = list(NUMBER.finditer(path.name))
    if len(places) != 1 or "%" in NUMBER.sub("", path.name) or "%" in str(path.parent):
        raise ValueError(pattern)
    place = places[0]
    width = int(place.group(2) or 1)
    if width > WIDEST:
        raise ValueError(pattern)
    fitting = re.compile(
        re.escape(path.name[: place.start()])
        + rf"(\d{{{width},{WIDEST}}})"
        + re.escape(path.name[place.end() :])
    )
    found = {}
    for file in path.parent.iterdir():
        match = fitting.fullmatch(file.name)
        if match and (len(match.group(1)) == width or match.group(1)[0] != "0"):
            found[int(match.group(1))] = file
    return found


def read_image(path: Path, kind: PictureKind) -> NDArray[Any]:
    """Pixels of an image file, read-only, not turned.

    Returns
    -------
    (H, W) uint8 for grey; (H, W, 3) uint8 BGR or (H, W) for colour; (H, W) uint16 (or the
    file's own type) for depth.

    Raises
    ------
    DamagedFrame
        When the file is missing or no image.
    """
    try:
        content = read_bytes(path, PICTURE_BYTES)
    except InputError as refusal:
        raise DamagedFrame(f"{path.name}: {refusal.what}") from None
    try:
        whole = bool(content) and not _is_cut_off(content)
        data = np.frombuffer(content, dtype=np.uint8)
        picture = cv2.imdecode(data, READ_FLAGS[kind]) if whole else None
    except cv2.error:
        picture = None
    if picture is None:
        raise DamagedFrame(f"the file {path.name} is damaged or not an image")
    if kind == "depth" and (picture.ndim != 2 or picture.dtype not in (np.uint16, np.uint8)):
        raise DamagedFrame(f"the file {path.name} is not a 16-bit depth map with one channel")
    picture.flags.writeable = False
    return picture


def _is_cut_off(content: bytes) -> bool:
    """Whether one of the parts of a PNG claims to be longer than the file, or its end is missing.

    OpenCV makes room for a part before it reads it: gigabytes for a file of some hundred bytes.
    """
    if not content.startswith(_PNG):
        return False
    at = len(_PNG)
    while content[at + 4 : at + 8] not in (b"IEND", b""):
        at += 12 + int.from_bytes(content[at : at + 4])  # length, kind, content, checksum
    return at >= len(content)


class NumberedImages:
    """Image files by number, counted from the lowest one; a gap is a damaged frame.

    Raises
    ------
    ValueError, OSError
        As :func:`numbered_files`; ValueError also where no file fits.
    """

    def __init__(self, folder: Path, pattern: str, kind: PictureKind) -> None:
        self._files = numbered_files(folder, pattern)
        if not self._files:
            raise ValueError(pattern)
        self._lowest = min(self._files)
        self._count = max(self._files) - self._lowest + 1
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
            missing = NUMBER.sub(lambda _: "%d", self._pattern) % (self._lowest + k)
            raise DamagedFrame(f"file number {self._lowest + k} is missing ({missing})")
        return read_image(file, self._kind)

    def close(self) -> None:
        """Nothing is held open."""
