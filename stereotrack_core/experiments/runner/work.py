"""Doing jobs: the runs of a batch go forward together, frame by frame, on the same clouds."""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable, Generator, Sequence
from pathlib import Path

from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.experiments.measures import measured
from stereotrack_core.experiments.runner.job import Job, JobResult, failure
from stereotrack_core.experiments.runner.lockstep import LockstepRun, RunInput, track_together
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.detections import own_detections
from stereotrack_core.recording.folder import fingerprint, open_recording
from stereotrack_core.recording.landmarks import LandmarkTrajectory


def do_batch(
    jobs: Sequence[Job],
    *,
    on_frames: Callable[[int], None] = lambda _: None,
    cancelled: Callable[[], bool] = lambda: False,
) -> Generator[JobResult, None, None]:
    """Do jobs that share their clouds; gives the result of each as soon as it is known.

    A job that fails does not stop the others.

    Parameters
    ----------
    jobs : sequence of Job
        They agree in ``clouds``.
    on_frames : callable, optional
        Told how many frames more were tracked, over all jobs.
    cancelled : callable, optional
        Asked after every frame whether to stop.
    """
    begun, waiting = time.perf_counter(), list(jobs)
    try:
        recording = recording_of(jobs[0])
        detections = own_detections(recording)
        blind = dataclasses.replace(recording, reference=None)  # the tracker never sees the truth
        inputs = [
            RunInput(blind, dataclasses.replace(job.spec, detections=detections)) for job in jobs
        ]
        seconds: float | None = None
        for run in track_together(
            inputs, on_frames=on_frames, cancelled=cancelled, go_on_after_errors=True
        ):
            if seconds is None:
                seconds = (time.perf_counter() - begun) / len(jobs)
            yield _result(waiting.pop(0), run, recording.reference, seconds)
    except Cancelled:
        raise
    except Exception as error:  # noqa: BLE001 - told as the result of every job
        for job in waiting:
            yield _failed(job, error)


def recording_of(job: Job) -> Recording:
    """The job's recording, as it was when the job was planned.

    Raises
    ------
    InputError
        Where it is not to be found on this machine, or is another one.
    """
    folder = Path(job.folder)
    recording = open_recording(folder)
    if fingerprint(recording) != job.fingerprint:
        raise InputError(
            "the recording has changed since the sweep was started",
            where=job.folder,
            remedy="Start the sweep again with the present recording.",
        )
    return recording


def _result(
    job: Job, tracked: LockstepRun, reference: LandmarkTrajectory | None, seconds: float
) -> JobResult:
    """What has become of a job that took this share of the time of its batch."""
    if tracked.error is not None:
        return _failed(job, tracked.error)
    begun = time.perf_counter()
    try:
        run = tracked.run()
        seconds += time.perf_counter() - begun
        speed = len(run.frame) / tracked.seconds if tracked.seconds > 0 else float("nan")
        values = measured(run, reference) | {"frames_per_second": speed, "seconds": seconds}
    except Exception as error:  # noqa: BLE001 - told as the result of the job
        return _failed(job, error)
    known = {name: value for name, value in values.items() if math.isfinite(value)}
    return JobResult(job.identity, "done", known, frames=len(run.frame))


def _failed(job: Job, error: Exception) -> JobResult:
    return failure(job.identity, error, final=isinstance(error, InputError))
