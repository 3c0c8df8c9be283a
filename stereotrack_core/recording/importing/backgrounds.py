"""The empty scene beside a source: a picture, or a video of which the median is taken."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stereotrack_core.arrays import ImageArray
from stereotrack_core.errors import InputError
from stereotrack_core.recording.images import (
    WHITEST,
    DamagedFrame,
    brightness_of,
    read_image,
)
from stereotrack_core.recording.importing.choices import Use
from stereotrack_core.recording.importing.image_groups import is_image
from stereotrack_core.recording.importing.readers import (
    first_picture,
    open_source,
)
from stereotrack_core.recording.importing.sources import look_at

_FRAMES_OF_A_VIDEO = 15


def check_background(use: Use) -> None:
    """Refuse a background that cannot be read, or whose size is not that of the source."""
    path = use.background
    if path is None:
        return
    if not path.is_file():
        raise InputError("there is no such file", where=str(path), remedy="Correct the path.")
    picture = _picture(path) if is_image(path) else first_picture(look_at([path]).sources[0])
    height, width = picture.shape[:2]
    if (width, height) != use.source.size:
        own = use.source.size
        raise InputError(
            f"the background of {use.source.name} has {width} x {height} pixels, its images have "
            f"{own[0]} x {own[1]}",
            where=str(path),
            remedy="Use a picture of the empty scene by the same camera, or none.",
        )


def empty_scene(path: Path, white: int = 0) -> ImageArray:
    """The picture (H, W) or (H, W, 3) of a file; of a video, the median of frames of all of it.

    `white`: value that becomes white where more than 8 bits are stored; 0 is the largest possible.
    """
    if is_image(path):
        return _picture(path, white)
    reader = open_source(replace(look_at([path]).sources[0], white=white), "colour")
    try:
        numbers = np.unique(np.linspace(0, reader.count() - 1, _FRAMES_OF_A_VIDEO).astype(int))
        pictures: list[NDArray[Any]] = [
            reader.read(int(k), lambda _number, _picture: None) for k in numbers
        ]
    except DamagedFrame as problem:
        raise _unreadable(path, problem) from None
    finally:
        reader.close()
    return np.asarray(np.median(pictures, axis=0).round(), dtype=np.uint8)


def _picture(path: Path, white: int = 0) -> ImageArray:
    try:
        picture = read_image(path, "stored")
    except DamagedFrame as problem:
        raise _unreadable(path, problem) from None
    return brightness_of(picture, white or WHITEST) if picture.dtype == np.uint16 else picture


def _unreadable(path: Path, problem: DamagedFrame) -> InputError:
    return InputError(str(problem), where=str(path), remedy="Use another picture, or none.")
