"""Jobs of a study, checked before anything long begins; known results are not computed again."""

import dataclasses
import hashlib
import json
import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.atomic import make_folder
from stereotrack_core.body.pose import Pose
from stereotrack_core.counting import counted
from stereotrack_core.errors import Cancelled, Finding, InputError
from stereotrack_core.evaluation.measures import MEASURES, measure_named
from stereotrack_core.evaluation.summary import Spread
from stereotrack_core.interop.first_pose import first_pose
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
from stereotrack_core.study.points import Point, Range, Search
from stereotrack_core.study.store import Store, segment_measures
from stereotrack_core.study.workers import ClusterWorkers, LocalWorkers
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
    return "-".join([*words, f"seed{job.seed}"])


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
        self._jobs: list[Job] = []
        self._fresh: set[str] = set()
        self._reused: set[str] = set()
        self._frames = self._wanted = 0
        self._written = time.monotonic()

    def do(self, jobs: Sequence[Job]) -> Outcome:
        """Compute the jobs that are missing."""
        return self._working(lambda: self._do(jobs))

    def search(
        self, study: Study, sources: Sequence[Source], ranges: Sequence[Range], by: str, trials: int
    ) -> Outcome:
        """Look for the point that is best by a measure."""

        def jobs_at(points: Sequence[Point]) -> list[Job]:
            return [job for one in sources for job in jobs_of(study, one, points, keep=False)]

        def search() -> None:
            measure = measure_named(by)
            proposer = Search(ranges, more_is_better=bool(measure and measure.more_is_better))
            own = len(jobs_at([Point()]))
            at_once = max(1, math.ceil(self._workers.count / own))
            tried = 0
            while tried < trials:
                points = proposer.ask(min(at_once, trials - tried))
                jobs = jobs_at(points)
                self._do(jobs)
                proposer.tell([_value(jobs, self._store.results, point, by) for point in points])
                tried += len(points)

        return self._working(search)

    # ---- what the workers tell

    def on_frames(self, count: int) -> None:
        """So many frames more were tracked."""
        self._frames = min(self._frames + count, self._wanted)  # a second try counts no more
        done = f"{len(self._fresh) + len(self._reused)} of {counted(len(self._jobs), 'run')}"
        self._work.tell(self._frames / self._wanted if self._wanted else 0.0, done)

    def on_result(self, job: Job, result: JobResult) -> None:
        """Keep a result."""
        self._store.keep(job, result)
        self._fresh.add(job.identity)
        if time.monotonic() - self._written > _TABLE_SECONDS:
            self._store.write_table(self._jobs)
            self._written = time.monotonic()

    # ---- inside

    def _working(self, work: Callable[[], object]) -> Outcome:
        stopped = False
        try:
            work()
        except Cancelled:
            stopped = True
        finally:
            self._store.write_table(self._jobs)
        return Outcome(tuple(self._jobs), len(self._reused), len(self._fresh), stopped)

    def _do(self, jobs: Sequence[Job]) -> None:
        undone = missing(jobs, self._store.results)
        waiting = [job for job in undone if job.identity not in self._fresh]
        names = {job.identity for job in waiting}
        self._jobs += jobs
        self._reused |= {job.identity for job in jobs} - names - self._fresh
        self._wanted += sum(len(job.frames) for job in waiting)
        if waiting:
            self._workers.do(waiting, self)


def run_study(
    study: Study, jobs: Sequence[Job], workers: Workers, work: Work = NO_WORK
) -> tuple[Outcome, Mapping[str, JobResult]]:
    """Compute the jobs that are missing, beside the study file. Raises InputError."""
    make_folder(study.runs)
    with workers, Store(study.table) as store:
        return StudyRun(store, workers, work).do(jobs), store.results


def _value(jobs: Sequence[Job], results: Mapping[str, JobResult], point: Point, by: str) -> float:
    """The mean of a measure at a point; NaN if any of its runs failed."""
    found = summarised([job for job in jobs if job.point == point], results, by)
    return math.nan if len(found) != 1 or found[0].failed else found[0].values[by].mean


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
    """Summaries of all points that have a result, those best by a measure first."""
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
    measure = measure_named(by)
    sign = -1.0 if measure is not None and measure.more_is_better else 1.0

    def cost(one: PointSummary) -> float:
        mean = one.values[by].mean
        return sign * mean if math.isfinite(mean) else math.inf

    return tuple(sorted(found, key=cost))
