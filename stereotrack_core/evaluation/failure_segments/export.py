"""Failures as strips of pictures and as a video."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path

import cv2
import numpy as np

from stereotrack_core.arrays import ImageArray
from stereotrack_core.atomic import filling
from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.evaluation.failure_segments.drawing import (
    WHITE,
    Paper,
    Shown,
    check_frames,
    evenly,
    person_window,
    picture_strip,
    write,
)
from stereotrack_core.evaluation.failure_segments.find import FailureSearch, Report
from stereotrack_core.evaluation.failure_segments.segment import (
    CAUSE_WORDS,
    FailureSegment,
    limbs_words,
)
from stereotrack_core.recording.description import Recording, View
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.writing import VideoWriter, write_png

_STRIP_FRAMES = 5
_AROUND = 0.3
"""Seconds before and after a failure that a video shows as well."""

_HEIGHT, _LINE = 400, 34
_ASPECT = 4.0 / 3.0
_DARK_PAPER, _INK = (24, 24, 24), (235, 235, 235)
_CRF = 20


def _shown(search: FailureSearch, recording: Recording, failure: FailureSegment) -> Shown:
    reference = search.reference if failure.found == "truth" else None
    return Shown(recording, search.run, failure.limbs, reference)


def strip_of(
    search: FailureSearch,
    recording: Recording,
    failure: FailureSegment,
    *,
    view: str | None = None,
    count: int = _STRIP_FRAMES,
    reader: FrameReader | None = None,
) -> ImageArray:
    """Evenly spread frames of a failure as a strip (H, W, 3) BGR; see :func:`picture_strip`."""
    frames = evenly(failure.first, failure.last, count)
    return picture_strip(_shown(search, recording, failure), frames, view, reader=reader)


def write_strips(
    folder: Path,
    search: FailureSearch,
    recording: Recording,
    failures: Sequence[FailureSegment],
    *,
    view: str | None = None,
    count: int = _STRIP_FRAMES,
    report: Report = lambda _share, _words: None,
    cancelled: Callable[[], bool] = lambda: False,
) -> int:
    """Write a strip of each failure as PNG into a folder, which is made; returns their number.

    The files are named as ``0144-0183-left-forearm-crossing-truth.png``. Raises InputError where
    not all of them can be written there; then none is, and Cancelled: none is written.
    """
    with filling(folder) as workplace, FrameReader(recording, read_ahead=0) as reader:
        for i, failure in enumerate(failures):
            if cancelled():
                raise Cancelled
            strip = strip_of(search, recording, failure, view=view, count=count, reader=reader)
            limbs = limbs_words(failure.limbs).replace(", ", "+").replace(" ", "-")
            name = f"{limbs}-{failure.verdict.cause}-{failure.found}"
            write_png(workplace / f"{failure.first:04d}-{failure.last:04d}-{name}.png", strip)
            report((i + 1) / len(failures), f"{i + 1} of {len(failures)}")
    return len(failures)


def before_peak_after(search: FailureSearch, failure: FailureSegment) -> list[int]:
    """Frames just before a failure, at its peak and just after it, as far as the run has them."""
    around = max(1, round(_AROUND * search.fps))
    frame = search.run.frame
    before = frame[frame <= failure.first - around]
    after = frame[frame >= failure.last + around]
    first = int(before[-1]) if len(before) else failure.first
    last = int(after[0]) if len(after) else failure.last
    return sorted({first, failure.peak_frame, last})


def evidence_picture(
    search: FailureSearch,
    recording: Recording,
    failure: FailureSegment,
    *,
    reader: FrameReader | None = None,
    paper: Paper = WHITE,
) -> ImageArray:
    """Before, peak and after beside each other (H, W, 3) BGR, in the view that shows it best."""
    shown, frames = _shown(search, recording, failure), before_peak_after(search, failure)
    return picture_strip(shown, frames, reader=reader, paper=paper)


def film_of(
    path: Path,
    search: FailureSearch,
    recording: Recording,
    failures: Sequence[FailureSegment],
    report: Report = lambda _share, _words: None,
    cancelled: Callable[[], bool] = lambda: False,
) -> None:
    """Write a video of failures, one after the other, with what is just before and after each.

    At the recording's own pace; every view is shown with the model's outline, the numbers and, for
    a single failure, its cause below. One that is not finished is taken away. Raises InputError for
    no frames, or where the file cannot be written, and Cancelled.
    """
    if path.suffix.lower() != ".mp4":
        raise InputError(
            "the name of a video must end in .mp4", where=str(path), remedy="Change the name."
        )
    around = round(_AROUND * search.fps)
    wanted = {k for e in failures for k in range(e.first - around, e.last + around + 1)}
    frames = sorted(wanted & set(search.run.frame.tolist()))
    check_frames(frames)
    limbs = tuple(dict.fromkeys(limb for failure in failures for limb in failure.limbs))
    title = [CAUSE_WORDS[failures[0].verdict.cause]] if len(failures) == 1 else []
    reference = search.reference if any(e.found == "truth" for e in failures) else None
    shown = Shown(recording, search.run, limbs, reference)
    with ExitStack() as opened:
        writer: VideoWriter | None = None
        for i, picture in enumerate(_pictures(shown, frames, title, opened)):
            if cancelled():
                raise Cancelled
            if writer is None:
                height, width = picture.shape[:2]
                writer = opened.enter_context(
                    VideoWriter(
                        path, fps=recording.fps, width=width, height=height, colour=True, crf=_CRF
                    )
                )
            writer.write(picture)
            report((i + 1) / len(frames), "rendering frames")


def _pictures(
    shown: Shown, frames: Sequence[int], title: Sequence[str], opened: ExitStack
) -> Iterator[ImageArray]:
    """All views of every frame, with the captions and the title below."""
    reader = opened.enter_context(FrameReader(shown.recording))
    windows = [
        person_window(shown.recording.reference_camera(view), shown.run, frames, _HEIGHT, _ASPECT)
        for view in reader.views
    ]
    for frame, caption in zip(frames, shown.captions(frames), strict=True):
        images = reader.frame_set(int(frame))
        tiles = [
            _named(shown.pictures(images, view, window)[1], view)
            for view, window in zip(reader.views, windows, strict=True)
        ]
        yield _with_words(_grid(tiles), [*caption, *title])


def _named(tile: ImageArray, view: View) -> ImageArray:
    cv2.rectangle(tile, (0, 0), (14 + 10 * len(view.name), 24), _DARK_PAPER, -1)
    write(tile, view.name, (7.0, 18.0), 15.0, _INK, bold=True)
    return tile


def _grid(tiles: Sequence[ImageArray]) -> ImageArray:
    """Tiles in rows of equal cells, as nearly square as can be."""
    across = math.ceil(math.sqrt(len(tiles)))
    down = math.ceil(len(tiles) / across)
    height = max(tile.shape[0] for tile in tiles)
    width = max(tile.shape[1] for tile in tiles)
    grid = np.full((down * height, across * width, 3), _DARK_PAPER, dtype=np.uint8)
    for i, tile in enumerate(tiles):
        top, left = (i // across) * height, (i % across) * width
        grid[top : top + tile.shape[0], left : left + tile.shape[1]] = tile
    return grid


def _with_words(picture: ImageArray, words: Sequence[str]) -> ImageArray:
    """A line of words below; the size is even, as videos want it."""
    width = picture.shape[1] + picture.shape[1] % 2
    height = picture.shape[0] + _LINE
    height += height % 2
    whole = np.full((height, width, 3), _DARK_PAPER, dtype=np.uint8)
    whole[: picture.shape[0], : picture.shape[1]] = picture
    write(whole, "    ".join(words), (10.0, picture.shape[0] + 0.68 * _LINE), 16.0, _INK)
    return whole
