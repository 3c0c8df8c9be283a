"""Kept runs of a study with stretches in which they are good, to check other settings on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.failure_segments.find import (
    FailureSearch,
    good_stretches,
    stretches_of,
)
from stereotrack_core.interop.run_npz import read_npz
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.study.description import Study, StudyRecording
from stereotrack_core.study.job import is_kept
from stereotrack_core.study.run import jobs_of, source_of
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.parameters import Settings


@dataclass(frozen=True, eq=False)
class GoodRun:
    """A kept run of a recording and stretches of it that are away from all failures."""

    recording: Recording  # with the reference that counts, which no tracker may see
    path: Path
    run: Run
    stretches: tuple[range, ...]
    views: Sequence[str]  # that were tracked

    @property
    def reference(self) -> LandmarkTrajectory | None:
        """The reference, if it knows frames of every stretch; else the run's own signs judge."""
        truth = self.recording.reference
        known = truth is not None and all(np.isin(one, truth.frame).any() for one in self.stretches)
        return truth if known else None


def good_run(
    study: Study, row: StudyRecording, settings: Settings, count: int, seconds: float
) -> GoodRun:
    """A run of a recording, preferably with these settings, and up to `count` good stretches.

    Raises InputError if the recording cannot be read, has no kept run, or is good nowhere.
    """
    source = source_of(study, row)
    jobs = jobs_of(study, source, study.settings.all_points(), keep=True)
    kept = [job for job in jobs if is_kept(job)]
    if not kept:
        remedy = "Track it with the settings of the study first."
        raise InputError("no run is kept", where=row.recording, remedy=remedy)
    job = min(kept, key=lambda one: one.spec.settings != settings)
    run, recording = read_npz(Path(job.keep)), source.recording
    search = FailureSearch(run, recording.fps, recording.reference, recording)
    found = good_stretches(search, stretches_of(search), count, seconds)
    if not found:
        remedy = "Track it in the study with other settings first."
        raise InputError(f"no {seconds:g} s without failures", where=row.recording, remedy=remedy)
    return GoodRun(recording, Path(job.keep), run, tuple(found), job.views)
