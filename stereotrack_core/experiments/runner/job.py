"""A job is one run with an identity by which its result is known again; doing jobs.

The runs of a batch go forward together, frame by frame, on the same clouds.
"""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, Protocol, TypeAlias

from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.experiments.measures import measured
from stereotrack_core.experiments.runner.lockstep import LockstepRun, RunInput, track_together
from stereotrack_core.experiments.sweep.points import Point
from stereotrack_core.interop.run_npz import read_meta, write_npz
from stereotrack_core.plain_data import Kind, check_kind
from stereotrack_core.project.setups import Corrections
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.detections import own_detections
from stereotrack_core.recording.folder import fingerprint, open_recording
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.run_spec import RunSpec

Status: TypeAlias = Literal["done", "failed"]

_IDENTITY = "job"
"""Key in the meta of a run that a job has kept."""


@dataclass(frozen=True, eq=False)
class Job:
    """One run, with everything that its outcome depends on."""

    identity: str
    clouds: str
    """`identity` and `clouds`: hashes of all that the result depends on, and that its clouds do,
    which jobs may share."""
    recording: str
    folder: str
    fingerprint: str
    """`folder` and `fingerprint`: where the recording is, the same on every machine that takes
    part, and what it has to be."""
    point: Point
    spec: RunSpec
    """With its frames and keypoints; without detections, which the recording has."""
    keep: str = ""
    """File that the complete run goes to, for which no error is measured; empty: only measures."""
    corrections: Corrections | None = None
    """What a project corrects of the recording."""

    @property
    def frames(self) -> range:
        """Frames that are tracked."""
        return self.spec.frames_of(0)

    @property
    def seed(self) -> int:
        """Seed of the run."""
        return self.spec.seed

    @property
    def views(self) -> Sequence[str]:
        """Views that are used."""
        return self.spec.views or ()


_FACTS: Kind = {
    "job": str,
    "status": str,
    "measures": {str: float},
    "frames": int,
    "error": str,
    "attempts": int,
}


@dataclass(frozen=True)
class JobResult:
    """What became of a job.

    The job has this identity. Measures are in their units, those that are known. A failure that is
    final comes again however often it is tried: the input is wrong.
    """

    identity: str
    status: Status
    measures: Mapping[str, float] = field(default_factory=dict)
    frames: int = 0
    error: str = ""
    final: bool = False
    attempts: int = 1

    @property
    def done(self) -> bool:
        """Whether there are measures."""
        return self.status == "done"

    def facts(self) -> dict[str, Any]:
        """The same as JSON takes it."""
        return {key: getattr(self, "identity" if key == "job" else key) for key in _FACTS}

    @classmethod
    def of_facts(cls, facts: Mapping[str, Any]) -> JobResult:
        """Read :meth:`facts` again. Raises InputError for those of anything else."""
        check_kind(facts, _FACTS, "the result of a job", "Compute it again.")
        if facts.get("status") not in ("done", "failed") or None in map(facts.get, _FACTS):
            raise InputError(
                "this is not the result of a job",
                where=str(facts.get("job")),
                remedy="Compute it again.",
            )
        return cls(facts["job"], **{key: facts[key] for key in _FACTS if key != "job"})


def failure(identity: str, error: BaseException, *, final: bool) -> JobResult:
    """A job that went wrong, with the error's words."""
    words = " ".join(str(error).split()) or "no details"
    said = words if final else f"{type(error).__name__}: {words}"
    return JobResult(identity, "failed", error=said, final=final)


class Watcher(Protocol):
    """Hears of everything that happens; called in the thread that asked for the jobs."""

    def on_frames(self, count: int) -> None:
        """So many frames more were tracked."""

    def on_result(self, job: Job, result: JobResult) -> None:
        """A job has come to its end; called once for each."""

    def stopped(self) -> bool:
        """Whether to stop."""


class Executor(Protocol):
    """Does jobs."""

    @property
    def count(self) -> int:
        """Jobs that are done at once."""

    def do(self, jobs: Sequence[Job], watcher: Watcher) -> None:
        """Do all jobs, whose identities differ; returns when each has a result.

        Raises Cancelled when the watcher wants to stop; results that were told stay valid.
        """


def do_batch(
    jobs: Sequence[Job],
    *,
    on_frames: Callable[[int], None] = lambda _: None,
    cancelled: Callable[[], bool] = lambda: False,
) -> Generator[JobResult, None, None]:
    """Do jobs that share their clouds; gives the result of each as soon as it is known.

    A job that fails does not stop the others. `on_frames` is told how many frames more were
    tracked, over all jobs.
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
            yield _result(waiting.pop(0), run, recording, seconds)
    except Cancelled:
        raise
    except Exception as error:  # noqa: BLE001 - told as the result of every job
        for job in waiting:
            yield _failed(job, error)


def recording_of(job: Job) -> Recording:
    """The job's recording, as it was when the job was planned.

    Raises InputError where it is not to be found on this machine, or is another one.
    """
    folder = Path(job.folder)
    recording = open_recording(folder)
    if fingerprint(recording) != job.fingerprint:
        raise InputError(
            "the recording has changed since the work was started",
            where=job.folder,
            remedy="Start it again with the present recording.",
        )
    return recording if job.corrections is None else job.corrections.applied_to(recording)


def is_kept(job: Job) -> bool:
    """Whether the run that a job keeps is in its place; always where it keeps none."""
    if not job.keep:
        return True
    try:
        return read_meta(Path(job.keep)).get(_IDENTITY) == job.identity
    except InputError:
        return False


def _result(job: Job, tracked: LockstepRun, recording: Recording, seconds: float) -> JobResult:
    """What has become of a job that took this share of the time of its batch."""
    # errors of a run that is kept are measured whenever they are asked for
    reference = None if job.keep else recording.reference
    if tracked.error is not None:
        return _failed(job, tracked.error)
    begun = time.perf_counter()
    try:
        run = tracked.run()
        seconds += time.perf_counter() - begun
        if job.keep:
            _keep(job, run, seconds)
        speed = len(run.frame) / tracked.seconds if tracked.seconds > 0 else float("nan")
        values = measured(run, reference, recording, job.spec.keypoints)
        values |= {"frames_per_second": speed, "seconds": seconds}
    except Exception as error:  # noqa: BLE001 - told as the result of the job
        return _failed(job, error)
    known = {name: value for name, value in values.items() if math.isfinite(value)}
    return JobResult(job.identity, "done", known, frames=len(run.frame))


def _keep(job: Job, run: Run, seconds: float) -> None:
    """Write a run to the place that its job names."""
    path = Path(job.keep)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"the folder cannot be made ({error.strerror})",
            where=str(path.parent),
            remedy="Make it possible to write there, and start again.",
        ) from error
    meta = {**run.meta, _IDENTITY: job.identity, "wall_seconds": seconds}
    write_npz(path, dataclasses.replace(run, meta=meta))


def _failed(job: Job, error: Exception) -> JobResult:
    return failure(job.identity, error, final=isinstance(error, InputError))
