"""The fit of a recording as a job that another process can do; nothing of Qt is loaded here."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.fit.depth import recorded_depth
from stereotrack_core.annotation.fit.fit import ClickFit
from stereotrack_core.annotation.fit.results import TrajectoryFit
from stereotrack_core.annotation.fit.settings import FitSettings
from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.body.proportions import Proportions
from stereotrack_core.recording.description import Recording


@dataclass(frozen=True, eq=False)
class FitJob:
    """Everything that a fit needs.

    Attributes
    ----------
    recording : Recording
    landmarks : LandmarkSet
    proportions : Proportions
    settings : FitSettings
    measured : mapping from frame to clicks
    frames : range
    gaps : tuple of range
    progress : Path
        File that the number of frames that are taken in is written to.
    """

    recording: Recording
    landmarks: LandmarkSet
    proportions: Proportions
    settings: FitSettings
    measured: Mapping[int, tuple[Click, ...]]
    frames: range
    gaps: tuple[range, ...]
    progress: Path


def do_fit(job: FitJob) -> TrajectoryFit:
    """Do it.

    Raises
    ------
    InputError
        Where images cannot be read.
    """
    recording = job.recording
    fitting = ClickFit(
        recording.cameras,
        job.landmarks,
        job.proportions,
        job.settings,
        fps=recording.fps,
        views={view.image.camera: view.name for view in recording.views},
    )

    def note(frame: int) -> None:
        with suppress(OSError):  # a fit goes on, though nobody sees how far it is
            job.progress.write_text(str(frame - job.frames.start + 1), encoding="ascii")

    with recorded_depth(recording, job.settings) as depth:
        return fitting.trajectory(
            job.measured, job.frames, clouds=depth, gaps=job.gaps, on_frame=note
        )


def frames_done(job: FitJob) -> int:
    """How many frames are taken in."""
    try:
        return int(job.progress.read_text(encoding="ascii") or 0)
    except (OSError, ValueError):
        return 0  # nothing is written yet, or is being written just now


def worker() -> Callable[[FitJob], TrajectoryFit]:
    """What a helper process answers with."""
    return do_fit
