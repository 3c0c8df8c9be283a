"""A video of some frames: every view with the model's outline, and the numbers."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path

import cv2
import numpy as np

from stereotrack_core.arrays import ImageArray
from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.evaluation.episodes.drawing import Window, draw_body, draw_reference, write
from stereotrack_core.evaluation.episodes.strip import (
    frame_captions,
    landmarks_at,
    meshes_at,
    person_window,
)
from stereotrack_core.recording.description import Recording, View
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.writing import VideoWriter
from stereotrack_core.tracking.frame import Run

_HEIGHT, _LINE = 400, 34
_ASPECT = 4.0 / 3.0
_PAPER, _INK = (24, 24, 24), (235, 235, 235)
_CRF = 20


def write_film(
    path: Path,
    recording: Recording,
    run: Run,
    frames: Sequence[int],
    *,
    limbs: Sequence[str] = (),
    reference: LandmarkTrajectory | None = None,
    title: str = "",
    reader: FrameReader | None = None,
    report: Callable[[float, str], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> None:
    """Write a video at the recording's own pace; one that is not finished is taken away.

    Parameters
    ----------
    path : Path
        Ends in .mp4.
    recording : Recording
    run : Run
    frames : sequence of int
    limbs : sequence of str
        Limbs whose errors are written and whose outlines are broader; see :func:`picture_strip`.
    reference : LandmarkTrajectory, optional
        Drawn dashed.
    title : str
        Written above.
    reader : FrameReader, optional
        Shared reader; one is opened where not given.
    report : callable, optional
        Called with the share done and with words.
    cancelled : callable, optional

    Raises
    ------
    InputError
        For no frames, or where the file cannot be written.
    Cancelled
    """
    if not len(frames):
        raise InputError(
            "there are no frames to show", where="frames", remedy="Select at least one."
        )
    if path.suffix.lower() != ".mp4":
        raise InputError(
            "the name of a video must end in .mp4", where=str(path), remedy="Change the name."
        )
    captions = frame_captions(run, frames, limbs, reference)
    own = reader or FrameReader(recording)
    windows = {
        view.name: person_window(recording.reference_camera(view), run, frames, _HEIGHT, _ASPECT)
        for view in own.views
    }
    writer: VideoWriter | None = None
    with ExitStack() as opened:
        if reader is None:
            opened.callback(own.close)
        for i, frame in enumerate(frames):
            if cancelled is not None and cancelled():
                raise Cancelled
            picture = _picture(recording, run, int(frame), own, windows, limbs, reference)
            picture = _with_words(picture, captions[i], title)
            if writer is None:
                height, width = picture.shape[:2]
                writer = opened.enter_context(
                    VideoWriter(
                        path, fps=recording.fps, width=width, height=height, colour=True, crf=_CRF
                    )
                )
            writer.write(picture)
            if report is not None:
                report((i + 1) / len(frames), "rendering frames")


def _picture(
    recording: Recording,
    run: Run,
    frame: int,
    reader: FrameReader,
    windows: Mapping[str, Window],
    limbs: Sequence[str],
    reference: LandmarkTrajectory | None,
) -> ImageArray:
    """All views of a frame, beside and below each other."""
    images = reader.frame_set(frame)
    meshes, truth = meshes_at(run, frame), landmarks_at(reference, frame)
    tiles = []
    for view in reader.views:
        camera = recording.reference_camera(view)
        window = windows[view.name]
        seen = images.views.get(view.name)
        tile = np.full((window.height, window.width, 3), 60, dtype=np.uint8)
        if seen is not None:
            tile = window.cut(seen.image)
        draw_body(tile, camera, window, meshes, thick=limbs)
        if truth is not None:
            draw_reference(tile, camera, window, truth)
        tiles.append(_named(tile, view))
    return _grid(tiles)


def _named(tile: ImageArray, view: View) -> ImageArray:
    turned = np.ascontiguousarray(np.rot90(tile, -(view.display_rotation // 90)))
    cv2.rectangle(turned, (0, 0), (14 + 10 * len(view.name), 24), _PAPER, -1)
    write(turned, view.name, (7.0, 18.0), 15.0, _INK, bold=True)
    return turned


def _grid(tiles: Sequence[ImageArray]) -> ImageArray:
    """Tiles in rows of equal cells, as nearly square as can be."""
    across = math.ceil(math.sqrt(len(tiles)))
    down = math.ceil(len(tiles) / across)
    height = max(tile.shape[0] for tile in tiles)
    width = max(tile.shape[1] for tile in tiles)
    grid = np.full((down * height, across * width, 3), _PAPER, dtype=np.uint8)
    for i, tile in enumerate(tiles):
        top, left = (i // across) * height, (i % across) * width
        grid[top : top + tile.shape[0], left : left + tile.shape[1]] = tile
    return grid


def _with_words(picture: ImageArray, lines: Sequence[str], title: str) -> ImageArray:
    """A line of words below; the size is even, as videos want it."""
    width = picture.shape[1] + picture.shape[1] % 2
    height = picture.shape[0] + _LINE
    height += height % 2
    whole = np.full((height, width, 3), _PAPER, dtype=np.uint8)
    whole[: picture.shape[0], : picture.shape[1]] = picture
    words = "    ".join([*lines, *([title] if title else [])])
    write(whole, words, (10.0, picture.shape[0] + 0.68 * _LINE), 16.0, _INK)
    return whole
