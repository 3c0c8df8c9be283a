"""Jobs of a study, checked before anything long begins; known results are not computed again."""

import dataclasses
import hashlib
import json
import math
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.atomic import make_folder
from stereotrack_core.body.pose import Pose
from stereotrack_core.counting import counted
from stereotrack_core.errors import Cancelled, Finding, InputError
from stereotrack_core.evaluation.failure_segments.find import (
    FailureSearch,
    good_stretches,
    stretches_of,
)
from stereotrack_core.evaluation.measures import MEASURES
from stereotrack_core.evaluation.summary import Spread
from stereotrack_core.interop.first_pose import first_pose
from stereotrack_core.interop.run_npz import read_npz
from stereotrack_core.parameters import parsed_settings
from stereotrack_core.project.detectors import keypoints_in
from stereotrack_core.project.entries import load_reference
from stereotrack_core.project.project import Project
from stereotrack_core.project.scenarios import scenarios_of
from stereotrack_core.reading import TABLE_BYTES, read_bytes
from stereotrack_core.recording.description import Recording, Segment, Subject
from stereotrack_core.recording.detections import OWN_FILE
from stereotrack_core.recording.folder import calibration_fingerprint, fingerprint, open_recording
from stereotrack_core.recording.keypoints import Keypoints
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.recording.selection import frames_within, seeds_of, tracked_views, views_of
from stereotrack_core.study.description import Study, StudyRecording, StudySettings
from stereotrack_core.study.job import Job, JobResult, is_kept
from stereotrack_core.study.points import Point
from stereotrack_core.study.store import Store, segment_measures
from stereotrack_core.study.workers import ClusterWorkers, LocalWorkers
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.presets import PRESETS, preset
from stereotrack_core.tracking.run_spec import RunSpec, measured_keypoints
from stereotrack_core.version import __version__
from stereotrack_core.work import NO_WORK, Work


@dataclass(frozen=True)
class Source:
    """A recording of a study with what its project and a detector say of it."""

    row: StudyRecording
    recording: Recording  # with the reference that counts
    keypoints: Keypoints | None
    frames: int
    truth: LandmarkTrajectory | None = None  # chosen in the project; None: the recording's own
    scenarios: tuple[Segment, ...] = ()  # the project's named stretches

    @cached_property
    def facts(self) -> dict[str, Any]:
        """Everything about the recording that the tracker is told, without its folder."""
        recording = self.recording
        digest, file, subject = None, recording.folder / OWN_FILE, recording.subject
        if file.is_file():
            digest = hashlib.blake2b(read_bytes(file, TABLE_BYTES), digest_size=16).hexdigest()
        # offsets only if there are any, so that jobs without keep the identity they had
        facts = {k: v for k, v in vars(subject or Subject()).items() if k != "offsets" or v}
        return {
            "fingerprint": fingerprint(recording),
            "calibration": calibration_fingerprint(recording),
            "fps": recording.fps,
            "subject": None if subject is None else facts,
            "detections": digest,
        }

    @cached_property
    def reference(self) -> str:
        """Hash of the reference: results of another one are not valid."""
        reference = self.recording.reference
        if reference is None:
            return _digest(None)
        points = np.nan_to_num(reference.points, nan=1e9)
        return _digest([reference.frame.tolist(), points.tolist()])


def source_of(study: Study, row: StudyRecording) -> Source:
    """Open a recording with its project and keypoints. Raises InputError."""
    folder = study.place(row.recording)
    if not folder.is_dir():
        remedy = f"Move it back to {folder}, or write its place into the study file."
        raise InputError("the recording was not found", row.recording, remedy)
    recording, truth = open_recording(folder), None
    scenarios: tuple[Segment, ...] = ()
    if row.project:
        with Project.open(study.place(row.project), read_only=True) as project:
            chosen, scenarios = project.chosen(project.references), scenarios_of(project)
            if chosen:
                truth = load_reference(project.references, chosen).trajectory()
    if truth is not None:
        recording = dataclasses.replace(recording, reference=truth)
    keypoints = None
    if row.keypoints:
        settings, path = study.settings, study.place(row.keypoints)
        keypoints = keypoints_in(path, recording, settings.layout, settings.person).keypoints
    with FrameReader(recording, read_ahead=0) as reader:
        count = reader.frame_count
    return Source(row, recording, keypoints, count, truth, scenarios)


def jobs_of(study: Study, source: Source, points: Sequence[Point], *, keep: bool) -> list[Job]:
    """Jobs of a recording: points times seeds; `keep`: with their runs. Raises InputError."""
    jobs = []
    for point in points:
        own = point.special("seed")
        seeds = seeds_of(study.settings.seeds) if own is None else [int(own)]
        jobs += [_job(study, source, point, seed) for seed in seeds]
    return [_kept(study, source.row, job) for job in jobs] if keep else jobs


def _job(study: Study, source: Source, point: Point, seed: int) -> Job:
    base, recording = study.settings, source.recording
    name = point.special("preset") or base.preset
    settings = preset(name).replaced(**{**parsed_settings(base.changes), **point.parameters})
    asked = views_of(recording, point.special("views") or base.views)
    keypoints = measured_keypoints(recording, settings, source.keypoints)
    tracked = tracked_views(recording, asked, keypoints)
    views = tuple(view.name for view in recording.views if view.name in tracked)
    frames = frames_within(point.special("frames") or base.frames, source.frames)
    init = first_pose(point.special("init") or base.init, frames.start, recording)
    told_init: Any = init
    if isinstance(init, Pose):
        told_init = {name: np.asarray(value).tolist() for name, value in sorted(vars(init).items())}
    smooth = point.by_name.get("smooth", base.smooth) is True
    clouds: dict[str, Any] = {"recording": source.facts, "depth": settings.depth.values()}
    clouds |= {"colour": settings.tracking.wants_colour, "views": views}
    clouds["frames"] = [frames.start, frames.stop]
    tracking: dict[str, Any] = {"clouds": clouds, "version": __version__}
    tracking |= {"settings": settings.values(), "seed": seed, "init": told_init, "smooth": smooth}
    told: dict[str, Any] = {"reference": source.reference}
    if source.scenarios:  # so that jobs without keep the identity they had
        told["scenarios"] = [[one.name, one.first, one.end] for one in source.scenarios]
    if keypoints is not None:
        tracking["keypoints"] = keypoints.fingerprint()
    return Job(
        identity=_digest({**tracking, **told}),
        tracking=_digest(tracking),
        clouds=_digest(clouds),
        recording=recording.name,
        folder=str(recording.folder.resolve()),
        fingerprint=source.facts["fingerprint"],
        point=point,
        spec=RunSpec(settings, name, frames, views, seed, init, smooth, keypoints=keypoints),
        truth=source.truth,
        scenarios=source.scenarios,
    )


def _kept(study: Study, row: StudyRecording, job: Job) -> Job:
    """The job with a file for its run; copies of a recording have runs of their own."""
    name = _run_name(study.settings, job)
    identity = _digest([job.identity, row.recording])
    keep = str(study.runs_of(row) / f"{name}.npz")
    return dataclasses.replace(job, identity=identity, recording=row.recording, keep=keep)


def _run_name(base: StudySettings, job: Job) -> str:
    """Preset and seed, and a few digits for everything else that was asked for."""
    name, settings = job.spec.preset, job.spec.settings
    own = name not in PRESETS or settings.values() != preset(name).values()
    point = job.point
    asked = [
        settings.values() if own else None,
        *(point.special(key) or getattr(base, key) for key in ("views", "frames", "init")),
        job.spec.smooth,
    ]
    words = [Path(name).stem if name.endswith(".toml") else name]
    if asked != [None, None, None, "auto", False]:
        words.append(_digest(asked)[:6])
    return "-".join([*words, f"seed{job.spec.seed}"])


def _digest(facts: Any) -> str:
    text = json.dumps(facts, sort_keys=True, separators=(",", ":"))
    return hashlib.blake2b(text.encode(), digest_size=12).hexdigest()


_TABLE_SECONDS = 5.0
Workers = LocalWorkers | ClusterWorkers


@dataclass(frozen=True)
class Plan:
    """Jobs of a study, and the recordings that cannot be tracked, with the reason."""

    jobs: tuple[Job, ...]
    left_out: tuple[Finding, ...]


def plan_study(study: Study, rows: Sequence[StudyRecording], work: Work = NO_WORK) -> Plan:
    """Jobs of those recordings that can be tracked. Raises InputError, Cancelled."""
    study.settings.check()
    points, jobs, left_out = study.settings.all_points(), [], []
    for i, row in enumerate(rows):
        work.step(i / len(rows), row.recording)
        try:
            jobs += jobs_of(study, source_of(study, row), points, keep=True)
        except InputError as error:
            left_out.append(Finding.of(error))
    return Plan(tuple(jobs), tuple(left_out))


@dataclass(frozen=True)
class Outcome:
    """How a study ended."""

    jobs: tuple[Job, ...]  # all that were wanted
    reused: int  # different jobs whose results were there already
    computed: int
    stopped: bool


def missing(jobs: Iterable[Job], results: Mapping[str, JobResult]) -> list[Job]:
    """Jobs to be computed, each once; those that failed in earlier commands are tried again."""
    wanted: dict[str, Job] = {}
    for job in jobs:
        result = results.get(job.identity)
        if result is None or not result.done or not is_kept(job):
            wanted.setdefault(job.identity, job)
    return list(wanted.values())


class StudyRun:
    """One command's work on a study; leaves table and journal behind, however it ends."""

    def __init__(self, store: Store, workers: Workers, work: Work = NO_WORK) -> None:
        self._store, self._workers, self._work = store, workers, work
        self.stopped = work.stopped
        self._jobs: Sequence[Job] = ()
        self._reused = self._computed = self._frames = self._wanted = 0
        self._written = time.monotonic()

    def do(self, jobs: Sequence[Job]) -> Outcome:
        """Compute the jobs that are missing."""
        waiting, stopped = missing(jobs, self._store.results), False
        self._jobs = jobs
        self._reused = len({job.identity for job in jobs}) - len(waiting)
        self._wanted = sum(len(job.frames) for job in waiting)
        try:
            if waiting:
                self._workers.do(waiting, self)
        except Cancelled:
            stopped = True
        finally:
            self._store.write_table(jobs)
        return Outcome(tuple(jobs), self._reused, self._computed, stopped)

    def on_frames(self, count: int) -> None:
        """So many frames more were tracked."""
        self._frames = min(self._frames + count, self._wanted)  # a second try counts no more
        done = f"{self._computed + self._reused} of {counted(len(self._jobs), 'run')}"
        self._work.tell(self._frames / self._wanted if self._wanted else 0.0, done)

    def on_result(self, job: Job, result: JobResult) -> None:
        """Keep a result."""
        self._store.keep(job, result)
        self._computed += 1
        if time.monotonic() - self._written > _TABLE_SECONDS:
            self._store.write_table(self._jobs)
            self._written = time.monotonic()


def run_study(
    table: Path, jobs: Sequence[Job], workers: Workers, work: Work = NO_WORK
) -> tuple[Outcome, Mapping[str, JobResult]]:
    """Compute the jobs that are missing from a study's table. Raises InputError."""
    make_folder(table.parent)
    with workers, Store(table) as store:
        return StudyRun(store, workers, work).do(jobs), store.results


@dataclass(frozen=True)
class PointSummary:
    """All recordings and seeds of one point together."""

    point: Point  # without its seed
    runs: int
    failed: int
    values: Mapping[str, Spread]  # by measure, over the runs that did not fail


def summarised(
    jobs: Iterable[Job], results: Mapping[str, JobResult], by: str
) -> tuple[PointSummary, ...]:
    """Summaries of all points that have a result, those least by a measure first."""
    groups: dict[Point, list[JobResult]] = {}
    for job in jobs:
        if job.identity in results:
            groups.setdefault(job.point.without_seed, []).append(results[job.identity])
    found = []
    for point, own in groups.items():
        good = [result.measures for result in own if result.done]
        names = [measure.name for measure in MEASURES] + segment_measures(good)
        values = {name: Spread.of(one.get(name, math.nan) for one in good) for name in names}
        found.append(PointSummary(point, len(good), len(own) - len(good), values))

    def cost(one: PointSummary) -> float:
        mean = one.values[by].mean
        return mean if math.isfinite(mean) else math.inf

    return tuple(sorted(found, key=cost))


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
