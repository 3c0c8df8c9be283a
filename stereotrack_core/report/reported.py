"""What a report is about, and everything that it tells, gathered in one place."""

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from stereotrack_core.annotation.reference import Reference
from stereotrack_core.errors import Cancelled, Finding, InputError
from stereotrack_core.evaluation.accuracy import Accuracy, accuracy_of
from stereotrack_core.evaluation.failure_segments.drawing import strip_of
from stereotrack_core.evaluation.failure_segments.find import FailureSearch, find_failures
from stereotrack_core.evaluation.failure_segments.segment import FailureSegment
from stereotrack_core.recording.description import Recording, Segment
from stereotrack_core.recording.findings import examine
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.repeating import what_differs
from stereotrack_core.tracking.stored import fps_of_run

MOST_STRIPS = 8  # failures that are shown in pictures: the longest ones

_QUALITY = 80

Progress = Callable[[float, str], None]


@dataclass(frozen=True, eq=False)
class Source:
    """What a report is made of."""

    name: str  # of the run, as people know it
    run: Run
    recording: Recording | None = None
    """None where it is not there any more; pictures are left out then."""
    reference: LandmarkTrajectory | None = None
    reference_name: str = ""
    states: Reference | None = None  # the reference with its uncertainty, where it states one
    frames: range | None = None  # that are reported; None for all
    repeat: str = ""  # command that tracks again

    @property
    def fps(self) -> float:
        """Frame sets per second; InputError where neither recording nor run states them."""
        if self.recording is not None:
            return self.recording.fps
        return fps_of_run(self.run)


@dataclass(frozen=True)
class ShownFailure:
    """A failure with its strip of pictures as a JPEG, where it has one."""

    failure: FailureSegment
    strip: bytes | None = None


@dataclass(frozen=True, eq=False)
class Reported:
    """Everything that a report tells."""

    source: Source  # its run is cut to the stretch that is reported
    segments: tuple[Segment, ...]  # within the stretch
    findings: tuple[Finding, ...]  # about the recording
    accuracy: Accuracy | None  # None without a reference
    failures: tuple[ShownFailure, ...]
    differs: tuple[str, ...]  # why tracking again may come out otherwise


def gathered(
    source: Source,
    *,
    on_progress: Progress = lambda _share, _words: None,
    cancelled: Callable[[], bool] = lambda: False,
) -> Reported:
    """Measure, find failures, draw strips; InputError if the run lacks frames, Cancelled."""
    source = dataclasses.replace(source, run=_cut(source.run, source.frames))
    run, recording = source.run, source.recording
    first, end = int(run.frame[0]), int(run.frame[-1]) + 1
    segments = tuple(
        Segment(s.name, max(s.first, first), min(s.end, end))
        for s in (() if recording is None else recording.segments)
        if s.first < end and s.end > first
    )
    on_progress(0.02, "reading the recording")
    findings = () if recording is None else examine(recording.folder, compare=True)
    accuracy = _accuracy(source, segments)
    return Reported(
        source=source,
        segments=segments,
        findings=findings,
        accuracy=accuracy,
        failures=_failures(source, on_progress, cancelled),
        differs=() if recording is None else what_differs(run, recording),
    )


def _cut(run: Run, frames: range | None) -> Run:
    first, end = (0, np.inf) if frames is None else (frames.start, frames.stop)
    inside = (run.frame >= first) & (run.frame < end)
    if not inside.any():
        raise InputError(
            "the run has none of these frames" if len(run.frame) else "the run has no frames",
            where="--frames",
            remedy="Choose frames that the run contains."
            if len(run.frame)
            else "Track the recording first.",
        )
    names = (
        *("frame", "landmarks", "x", "P", "tracked", "unexplained_fraction", "residual"),
        *("innovation", "limb_sigma_deg", "limb_lost", "seconds"),
    )
    return dataclasses.replace(run, **{name: getattr(run, name)[inside] for name in names})


def _accuracy(source: Source, segments: Sequence[Segment]) -> Accuracy | None:
    if source.reference is None:
        return None
    frame = source.run.frame
    stretch = range(int(frame[0]), int(frame[-1]) + 1)
    found = accuracy_of(source.run, source.reference, source.states, segments, stretch)
    return found if len(found.errors.frame) else None


def _failures(
    source: Source, on_progress: Progress, cancelled: Callable[[], bool]
) -> tuple[ShownFailure, ...]:
    searched = FailureSearch(source.run, source.fps, source.reference, source.recording)
    found = find_failures(
        searched, lambda share, words: on_progress(0.05 + 0.55 * share, words), cancelled
    )
    if source.reference is not None:
        found = tuple(failure for failure in found if failure.found == "truth")
    recording = source.recording
    if recording is None:
        return tuple(ShownFailure(failure) for failure in found)
    longest = sorted(found, key=lambda e: e.first - e.last)[:MOST_STRIPS]
    shown = []
    with FrameReader(recording, read_ahead=0) as reader:
        for i, failure in enumerate(found):
            if cancelled():
                raise Cancelled
            on_progress(0.6 + 0.4 * i / len(found), "rendering failures")
            strip = None
            if failure in longest:
                picture = strip_of(searched, recording, failure, reader)
                done, data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
                strip = data.tobytes() if done else None
            shown.append(ShownFailure(failure, strip))
    return tuple(shown)
