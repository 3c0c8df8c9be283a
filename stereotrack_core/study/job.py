"""A job is one run with an identity; the jobs of a batch go forward on the same clouds."""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, Literal, NamedTuple, Protocol, TypeAlias

from stereotrack_core.atomic import make_folder
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.failure_segments.find import (
    FailureSearch,
    stretches_of,
    with_reasons,
)
from stereotrack_core.evaluation.failure_segments.reasons import WHY_WORDS
from stereotrack_core.evaluation.joint_angles import RANGES, angle_ranges, angles_of_run
from stereotrack_core.evaluation.measures import measure_named, measured, of_segments
from stereotrack_core.interop.run_npz import read_meta, read_npz, write_npz
from stereotrack_core.plain_data import Kind, check_kind
from stereotrack_core.recording.description import Recording, Segment
from stereotrack_core.recording.folder import fingerprint, open_recording
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.study.points import Point
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.lockstep import track_together
from stereotrack_core.tracking.run_spec import RunSpec

Status: TypeAlias = Literal["done", "failed"]
_TRACKED_AS = "job"  # key in the meta of a kept run: the identity of how it was tracked


@dataclass(frozen=True, eq=False)
class Job:
    """One run, with everything that its result depends on."""

    identity: str  # hash of all that the result depends on: tracking and reference
    tracking: str  # hash of all that the run depends on; equal: a kept run is measured again
    clouds: str  # hash of all that the clouds depend on, which jobs may share
    recording: str
    folder: str  # absolute path of the recording, the same on every machine that takes part
    fingerprint: str  # of the recording; another one is refused
    point: Point
    spec: RunSpec  # with frames and keypoints
    keep: str = ""  # file for the complete run; empty: only measures are kept
    truth: LandmarkTrajectory | None = None  # the project's reference; None: the recording's own
    scenarios: tuple[Segment, ...] = ()  # the project's named stretches

    @property
    def frames(self) -> range:
        """Frames that are tracked."""
        return self.spec.frames_of(0)

    @property
    def views(self) -> Sequence[str]:
        """Views that are used."""
        return self.spec.views or ()


_FACTS: Kind = {"job": str, "status": str, "measures": {str: float}, "frames": int}
_FACTS |= {"error": str, "attempts": int}


@dataclass(frozen=True)
class JobResult:
    """The result of the job with this identity."""

    identity: str
    status: Status
    measures: Mapping[str, float] = field(default_factory=dict)  # in their own units
    frames: int = 0
    error: str = ""
    final: bool = False  # whether trying again would fail again: the input is wrong
    attempts: int = 1

    @property
    def done(self) -> bool:
        """Whether there are measures."""
        return self.status == "done"

    def facts(self) -> dict[str, Any]:
        """The result as JSON takes it."""
        return {key: getattr(self, "identity" if key == "job" else key) for key in _FACTS}

    @classmethod
    def of_facts(cls, facts: Mapping[str, Any]) -> JobResult:
        """Read :meth:`facts` again. Raises InputError for those of anything else."""
        check_kind(facts, _FACTS, "the result of a job", "Compute it again.")
        if facts.get("status") not in ("done", "failed") or None in map(facts.get, _FACTS):
            what = "this is not the result of a job"
            raise InputError(what, str(facts.get("job")), "Compute it again.")
        return cls(facts["job"], **{key: facts[key] for key in _FACTS if key != "job"})


def failure(identity: str, error: BaseException) -> JobResult:
    """The result of a job that raised an error."""
    words = " ".join(str(error).split()) or "no details"
    final = isinstance(error, InputError)
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


def do_batch(
    jobs: Sequence[Job], *, on_frames: Callable[[int], None] = lambda _: None
) -> Generator[JobResult, None, None]:
    """Do jobs that share their clouds; gives each result as soon as it is known.

    A kept run that was tracked in the same way is only measured.
    """
    waiting = list(jobs)
    try:
        recording = recording_of(jobs[0])
        for job in [one for one in jobs if one.keep and is_kept(one)]:
            waiting.remove(job)
            on_frames(len(job.frames))
            yield _result(job, recording, partial(read_npz, Path(job.keep)))
        if waiting:
            yield from _tracked(waiting, recording, on_frames)
    except Exception as error:  # noqa: BLE001 - told as the result of every job
        for job in waiting:
            yield failure(job.identity, error)


def _tracked(
    waiting: list[Job], recording: Recording, on_frames: Callable[[int], None]
) -> Generator[JobResult, None, None]:
    """Results of jobs, which are taken from the list as soon as they have one."""
    count, begun = len(waiting), time.perf_counter()
    blind = dataclasses.replace(recording, reference=None)  # the tracker never sees the truth
    specs = [job.spec for job in waiting]
    share: float | None = None
    for made in track_together(blind, specs, on_frames=on_frames):
        if share is None:
            share = (time.perf_counter() - begun) / count
        job = waiting.pop(0)
        if made.error is not None:
            yield failure(job.identity, made.error)
            continue

        def finished(job: Job = job, made: Any = made, share: float = share) -> Run:
            before = time.perf_counter()
            run: Run = made.run()
            seconds = share + time.perf_counter() - before
            speed = len(run.frame) / made.seconds if made.seconds > 0 else None
            meta = {**run.meta, _TRACKED_AS: job.tracking, "wall_seconds": seconds}
            run = dataclasses.replace(run, meta={**meta, "frames_per_second": speed})
            if job.keep:
                make_folder(Path(job.keep).parent)
                write_npz(Path(job.keep), run)
            return run

        yield _result(job, recording, finished)


def recording_of(job: Job) -> Recording:
    """The job's recording, unchanged since it was planned. Raises InputError."""
    folder = Path(job.folder)
    recording = open_recording(folder)
    if fingerprint(recording) != job.fingerprint:
        what = "the recording has changed since the work was started"
        raise InputError(what, job.folder, "Start it again with the present recording.")
    return recording


def is_kept(job: Job) -> bool:
    """Whether the run that a job keeps is in its place; true for a job that keeps none."""
    if not job.keep:
        return True
    try:
        return read_meta(Path(job.keep)).get(_TRACKED_AS) == job.tracking
    except InputError:
        return False


def _result(job: Job, recording: Recording, finished: Callable[[], Run]) -> JobResult:
    truth = job.truth if job.truth is not None else recording.reference
    try:
        run = finished()
        values = measured(run, truth, recording, job.spec.keypoints)
        values |= of_segments(run, truth, (*recording.segments, *job.scenarios))
        values["seconds"] = float(run.meta["wall_seconds"])
        values["frames_per_second"] = float(run.meta.get("frames_per_second") or math.nan)
        if job.keep:
            values |= values_of(run, recording, truth)
    except Exception as error:  # noqa: BLE001 - told as the result of the job
        return failure(job.identity, error)
    known = {name: value for name, value in values.items() if math.isfinite(value)}
    return JobResult(job.identity, "done", known, frames=len(run.frame))


_PERCENTILES = {"median": "median", "p95": "95th percentile"}


class Named(NamedTuple):
    """What a value is, as the exported table says it."""

    measure: str
    statistic: str
    unit: str  # ``mm``, ``deg``, ``%``, ``s``; ``1`` for a pure number or a count


def values_of(run: Run, recording: Recording, truth: LandmarkTrajectory | None) -> dict[str, float]:
    """Values by name, ``left_elbow_flexion:range``, with how many failures have which reason."""
    tracked = float(run.tracked.sum())
    search = FailureSearch(run, recording.fps, truth, recording)
    failures = stretches_of(search)
    by_signs = sum(one.found == "signs" for one in failures)
    found = {"frames_tracked:count": tracked, "failures_by_signs:count": float(by_signs)}
    if truth is not None:
        found["failures_by_error:count"] = float(len(failures) - by_signs)
    if not tracked:
        return found
    whys = [one.reason.why for one in with_reasons(search, failures) if one.reason is not None]
    if whys:
        found |= {f"failures_{why}:count": float(whys.count(why)) for why in WHY_WORDS}
    for name, known in angle_ranges(angles_of_run(run))[0].angles.items():
        found |= {f"{name}:{statistic}": known[statistic] for statistic in RANGES}
    return found


def named(name: str) -> Named:
    """What a value of this name is."""
    whole, _, statistic = name.partition(":")
    if statistic:
        return Named(whole, statistic, "1" if statistic == "count" else "deg")
    measure = measure_named(name)
    unit = measure.unit if measure is not None else ""
    start, _, end = name.rpartition("_")
    if end in _PERCENTILES:
        return Named(start, _PERCENTILES[end], unit)
    return Named(name, "share" if unit == "%" else "mean", unit or "1")
