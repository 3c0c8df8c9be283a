"""Failures as strips of pictures."""

from __future__ import annotations

from stereotrack_core.arrays import ImageArray
from stereotrack_core.evaluation.failure_segments.drawing import (
    WHITE,
    Paper,
    Shown,
    evenly,
    picture_strip,
)
from stereotrack_core.evaluation.failure_segments.find import FailureSearch
from stereotrack_core.evaluation.failure_segments.segment import FailureSegment
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader

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
    reader: FrameReader,
) -> ImageArray:
    """Evenly spread frames of a failure as a strip (H, W, 3) BGR; see :func:`picture_strip`."""
    frames = evenly(failure.first, failure.last, _STRIP_FRAMES)
    return picture_strip(_shown(search, recording, failure), frames, reader)


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
    reader: FrameReader,
    paper: Paper = WHITE,
) -> ImageArray:
    """Before, peak and after beside each other (H, W, 3) BGR, in the view that shows it best."""
    shown, frames = _shown(search, recording, failure), before_peak_after(search, failure)
    return picture_strip(shown, frames, reader, paper)
