"""Doing jobs: the runs of a batch go forward together, frame by frame, on the same clouds."""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable, Generator, Sequence
from contextlib import ExitStack
from pathlib import Path

from stereotrack_core.depth.chain import DepthChain
from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.experiments.sweep.clouds import BatchClouds, CloudTaker
from stereotrack_core.experiments.sweep.jobs import Job
from stereotrack_core.experiments.sweep.measures import measured
from stereotrack_core.experiments.sweep.results import JobResult, failure
from stereotrack_core.recording.chroma import has_colours
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.detection_csv import own_detections
from stereotrack_core.recording.detections import Detections
from stereotrack_core.recording.fingerprint import fingerprint
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.tracking.frame import TrackedFrame, run_of
from stereotrack_core.tracking.pipeline import Pipeline
from stereotrack_core.tracking.run import Run
from stereotrack_core.tracking.run_spec import RunSpec


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

    Raises
    ------
    Cancelled
    """
    with ExitStack() as stack:
        try:
            recording = recording_of(jobs[0])
            detections = own_detections(recording) or Detections()
            clouds = _clouds_of(jobs[0], recording, stack)
        except Exception as error:  # noqa: BLE001 - told as the result of every job
            for job in jobs:
                yield failure(job.identity, error, final=isinstance(error, InputError))
            return
        yield from _Batch(jobs, recording, detections, clouds).results(on_frames, cancelled)


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
            "this is not the recording that the sweep was begun with",
            where=job.folder,
            remedy="Begin the sweep again, so that it is planned with the recording as it is now.",
        )
    return recording


def _clouds_of(job: Job, recording: Recording, stack: ExitStack) -> BatchClouds:
    colour = job.settings.tracking.wants_colour and has_colours(recording, job.views)
    chain = DepthChain(recording, job.settings.depth, views=job.views, colour=colour)
    stack.callback(chain.close)
    reader = stack.enter_context(FrameReader(recording, views=job.views, colour=colour))
    return BatchClouds(chain, reader)


class _Batch:
    """Runs that go forward together."""

    def __init__(
        self,
        jobs: Sequence[Job],
        recording: Recording,
        detections: Detections,
        clouds: BatchClouds,
    ) -> None:
        self._frames = jobs[0].frames
        self._reference = recording.reference
        # the tracker never sees the truth
        blind = dataclasses.replace(recording, reference=None)
        self._runs = [_OneRun(job, blind, clouds.taker(), detections) for job in jobs]

    def results(
        self, on_frames: Callable[[int], None], cancelled: Callable[[], bool]
    ) -> Generator[JobResult, None, None]:
        begun = time.perf_counter()
        with ExitStack() as stack:
            for run in self._runs:
                stack.callback(run.close)
            for _ in self._frames:
                for run in self._runs:
                    if run.error is None:
                        run.step()
                        on_frames(1)
                        if cancelled():
                            raise Cancelled
            share = (time.perf_counter() - begun) / len(self._runs)
            for run in self._runs:
                yield run.result(self._reference, share)


class _OneRun:
    """One run of a batch; an error ends it and nothing else."""

    def __init__(
        self, job: Job, recording: Recording, taker: CloudTaker, detections: Detections
    ) -> None:
        self._job = job
        self._recording = recording
        self._taker = taker
        self._detections = detections
        self._found: list[TrackedFrame] = []
        self._alone = 0.0
        self._pipeline: Pipeline | None = None
        self._going: Generator[TrackedFrame, None, None] | None = None
        self.error: Exception | None = None

    def step(self) -> None:
        """Track the next frame."""
        try:
            if self._going is None:
                self._pipeline = self._begun()
                self._going = self._pipeline.frames(self._job.frames)
            tracked = next(self._going)
            self._alone += _seconds_of(tracked)
            self._found.append(tracked.without_cloud())
        except Exception as error:  # noqa: BLE001 - told as the result of the job
            self.error = error
            self.close()

    def result(self, reference: LandmarkTrajectory | None, seconds: float) -> JobResult:
        """What has become of the job.

        Parameters
        ----------
        reference : LandmarkTrajectory or None
        seconds : float
            Share of the wall time in which the batch was tracked.
        """
        if self.error is None:
            try:
                return self._measured(reference, seconds)
            except Exception as error:  # noqa: BLE001 - told as the result of the job
                self.error = error
        return failure(self._job.identity, self.error, final=isinstance(self.error, InputError))

    def close(self) -> None:
        """Take no more clouds."""
        if self._going is not None:
            self._going.close()
        if self._pipeline is not None:
            self._pipeline.close()
        self._taker.leave()

    def _begun(self) -> Pipeline:
        job = self._job
        return Pipeline(
            self._recording,
            RunSpec(
                job.settings,
                views=job.views,
                seed=job.seed,
                init=job.init,
                preset=job.preset,
                detections=self._detections,
            ),
            clouds=self._taker,
        )

    def _run(self) -> Run:
        assert self._pipeline is not None  # noqa: S101 - there is at least one frame
        if self._job.smooth:
            return self._pipeline.smoothed_run(self._found)
        return run_of(self._found, self._pipeline.origin())

    def _measured(self, reference: LandmarkTrajectory | None, seconds: float) -> JobResult:
        begun = time.perf_counter()
        run = self._run()
        seconds += time.perf_counter() - begun
        speed = len(run.frame) / self._alone if self._alone > 0 else float("nan")
        values = measured(run, reference) | {"frames_per_second": speed, "seconds": seconds}
        known = {name: value for name, value in values.items() if math.isfinite(value)}
        return JobResult(self._job.identity, "done", known, frames=len(run.frame))


def _seconds_of(tracked: TrackedFrame) -> float:
    """What a frame took from its images to its pose; the parts of a view's depth are in "views"."""
    made = sum(tracked.cloud.seconds.get(stage, 0.0) for stage in ("views", "outliers"))
    return tracked.seconds.get("read", 0.0) + made + sum(tracked.estimate.seconds.values())
