"""Pictures of the empty scene."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stereotrack_core.arrays import ImageArray
from stereotrack_core.errors import InputError
from stereotrack_core.recording.description import Stream, View
from stereotrack_core.recording.numbered import is_pattern, read_image
from stereotrack_core.recording.pictures import PictureKind
from stereotrack_core.recording.stream_files import IMAGE_SUFFIXES, inside, open_stream
from stereotrack_core.recording.stream_source import DamagedFrame

FRAMES_OF_A_VIDEO = 15
"""Frames whose median is the background where it is a video; spread over its length."""


def background_picture(
    folder: Path, view: View, kind: PictureKind
) -> tuple[ImageArray | None, ImageArray] | None:
    """The empty scene as (left or None, image), or None where the view states none for a stream.

    Raises
    ------
    InputError
        When it cannot be read.
    """
    if view.image.background is None or (view.left and view.left.background is None):
        return None
    key = "right" if view.kind == "stereo" else "image"
    image = _picture(folder, view, view.image, key, kind)
    left = None if view.left is None else _picture(folder, view, view.left, "left", kind)
    return left, image


def _picture(folder: Path, view: View, stream: Stream, key: str, kind: PictureKind) -> ImageArray:
    where = f"{folder / 'recording.toml'}, view {view.name}, {key}.background"
    file = stream.background or ""
    path = inside(folder, file, where)
    try:
        if not is_pattern(file) and path.suffix.lower() in IMAGE_SUFFIXES:
            return read_image(path, kind)
        source = open_stream(folder, file, kind, where)
        try:
            numbers = np.unique(np.linspace(0, source.count() - 1, FRAMES_OF_A_VIDEO).astype(int))
            pictures = [source.read(int(n), _forget) for n in numbers if n >= 0]
        finally:
            source.close()
    except DamagedFrame as problem:
        raise InputError(
            str(problem), where=where, remedy="Replace the file or remove the key."
        ) from None
    if not pictures:
        raise InputError("it contains no image", where=where, remedy="Remove the key.")
    median: ImageArray = np.median(pictures, axis=0).round().astype(np.uint8)
    return median


def _forget(number: int, picture: NDArray[Any]) -> None:
    """Pictures on the way are not needed."""
