"""Failures as strips of pictures."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from stereotrack_core.arrays import ImageArray
from stereotrack_core.atomic import filling
from stereotrack_core.errors import Cancelled
from stereotrack_core.evaluation.failure_segments.drawing import (
    WHITE,
    Paper,
    Shown,
    evenly,
    picture_strip,
)
from stereotrack_core.evaluation.failure_segments.find import FailureSearch, Report
from stereotrack_core.evaluation.failure_segments.segment import (
    FailureSegment,
    limbs_words,
)
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.writing import write_png

_STRIP_FRAMES = 5
_AROUND = 0.3
"""Seconds before and after a failure that are shown as well."""


def _shown(search: FailureSearch, recording: Recording, failure: FailureSegment) -> Shown:
    reference = search.reference if failure.found == "truth" else None
    return Shown(recording, search.run, failure.limbs, reference)


def strip_of(
    search: FailureSearch,
    recording: Recording,
    failure: FailureSegment,
    reader: FrameReader | None = None,
) -> ImageArray:
    """Evenly spread frames of a failure as a strip (H, W, 3) BGR; see :func:`picture_strip`."""
    frames = evenly(failure.first, failure.last, _STRIP_FRAMES)
    return picture_strip(_shown(search, recording, failure), frames, reader=reader)


def write_strips(
    folder: Path,
    search: FailureSearch,
    recording: Recording,
    failures: Sequence[FailureSegment],
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
            strip = strip_of(search, recording, failure, reader)
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
