"""Doing a study: known results are not computed again, new ones are kept at once."""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from stereotrack_core.counting import counted
from stereotrack_core.errors import Cancelled, Finding, InputError
from stereotrack_core.evaluation.measures import MEASURES, measure_named
from stereotrack_core.evaluation.summary import Spread
from stereotrack_core.study.description import Study, StudyRecording
from stereotrack_core.study.job import Job, JobResult, Workers, is_kept
from stereotrack_core.study.plan import Source, jobs_of, source_of
from stereotrack_core.study.points import Point
from stereotrack_core.study.search import Range, Search
from stereotrack_core.study.store import Store

_TABLE_SECONDS = 5.0

Progress = Callable[[float, str], None]
"""Is told the share that is done, 0 to 1, and what is being done."""


@dataclass(frozen=True)
class Plan:
    """Jobs of a study, and the recordings that cannot be tracked, with the reason."""

    jobs: tuple[Job, ...]
    left_out: tuple[Finding, ...]


def plan_study(
    study: Study,
    rows: Sequence[StudyRecording],
    *,
    on_progress: Progress = lambda _share, _words: None,
    cancelled: Callable[[], bool] = lambda: False,
) -> Plan:
    """Jobs of some recordings, whose runs are kept; one that cannot be tracked stops no other.

    Raises InputError if the settings make no sense, and Cancelled.
    """
    study.settings.check()
    points, jobs, left_out = study.settings.all_points(), [], []
    for i, row in enumerate(rows):
        if cancelled():
            raise Cancelled
        on_progress(i / len(rows), row.recording)
        try:
            jobs += jobs_of(study, source_of(study, row), points, keep=True)
        except InputError as error:
            left_out.append(Finding.of(error))
    return Plan(tuple(jobs), tuple(left_out))


@dataclass(frozen=True)
class Outcome:
    """How a study ended."""

    jobs: tuple[Job, ...]
    """All that were wanted."""
    reused: int
    """Different jobs whose results were there already."""
    computed: int
    stopped: bool


def missing(
    jobs: Iterable[Job], results: Mapping[str, JobResult], *, again: bool = False
) -> list[Job]:
    """Jobs to be computed, each once; those that failed in earlier commands are tried again."""
    wanted: dict[str, Job] = {}
    for job in jobs:
        result = results.get(job.identity)
        if again or result is None or not result.done or not is_kept(job):
            wanted.setdefault(job.identity, job)
    return list(wanted.values())


class StudyRun:
    """One command's work on a study; leaves table and journal behind, however it ends."""

    def __init__(
        self,
        store: Store,
        workers: Workers,
        *,
        again: bool = False,
        on_progress: Progress = lambda _share, _words: None,
        cancelled: Callable[[], bool] = lambda: False,
    ) -> None:
        self._store, self._workers, self._again = store, workers, again
        self._on_progress = on_progress
        self.stopped = cancelled
        self._jobs: list[Job] = []
        self._fresh: set[str] = set()
        self._reused: set[str] = set()
        self._frames = self._wanted = 0
        self._written = time.monotonic()

    def do(self, jobs: Sequence[Job]) -> Outcome:
        """Compute the jobs that are missing."""
        return self._working(lambda: self._do(jobs))

    def search(
        self,
        study: Study,
        sources: Sequence[Source],
        ranges: Sequence[Range],
        *,
        by: str,
        trials: int,
    ) -> Outcome:
        """Look for the point that is best by a measure."""

        def jobs_at(points: Sequence[Point]) -> list[Job]:
            return [job for one in sources for job in jobs_of(study, one, points, keep=False)]

        def search() -> None:
            measure = measure_named(by)
            proposer = Search(ranges, more_is_better=bool(measure and measure.more_is_better))
            own = len(jobs_at([Point()]))
            at_once = max(1, math.ceil(self._workers.count / own))
            batch, tried = self._store.search_batch(repr((tuple(ranges), by)), at_once), 0
            while tried < trials:
                points = proposer.ask(min(batch, trials - tried))
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
        self._on_progress(self._frames / self._wanted if self._wanted else 0.0, done)

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
        waiting = [
            dataclasses.replace(job, again=self._again)
            for job in missing(jobs, self._store.results, again=self._again)
            if job.identity not in self._fresh
        ]
        names = {job.identity for job in waiting}
        self._jobs += jobs
        self._reused |= {job.identity for job in jobs} - names - self._fresh
        self._wanted += sum(len(job.frames) for job in waiting)
        if waiting:
            self._workers.do(waiting, self)


def run_study(
    study: Study,
    jobs: Sequence[Job],
    workers: Workers,
    *,
    again: bool = False,
    on_progress: Progress = lambda _share, _words: None,
    cancelled: Callable[[], bool] = lambda: False,
) -> tuple[Outcome, Mapping[str, JobResult]]:
    """Compute the jobs that are missing and keep their runs beside the study file.

    Raises InputError if nothing can be written there, or another process is at it.
    """
    try:
        study.runs.mkdir(exist_ok=True)
    except OSError as error:
        raise InputError(
            f"the folder for runs cannot be made ({error.strerror})",
            where=str(study.runs),
            remedy="Make it possible to write beside the study file.",
        ) from error
    with workers, Store(study.table) as store:
        work = StudyRun(store, workers, again=again, on_progress=on_progress, cancelled=cancelled)
        return work.do(jobs), store.results


def _value(jobs: Sequence[Job], results: Mapping[str, JobResult], point: Point, by: str) -> float:
    """The mean of a measure at a point; NaN if any of its runs failed."""
    found = summarised([job for job in jobs if job.point == point], results, by)
    return math.nan if len(found) != 1 or found[0].failed else found[0].values[by].mean


@dataclass(frozen=True)
class PointSummary:
    """All recordings and seeds of one point together."""

    point: Point
    """Without its seed."""
    runs: int
    failed: int
    values: Mapping[str, Spread]
    """By measure, over the runs that did not fail."""


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
        values = {
            measure.name: Spread.of(one.get(measure.name, math.nan) for one in good)
            for measure in MEASURES
        }
        found.append(PointSummary(point, len(good), len(own) - len(good), values))
    measure = measure_named(by)
    sign = -1.0 if measure is not None and measure.more_is_better else 1.0

    def cost(one: PointSummary) -> float:
        mean = one.values[by].mean
        return sign * mean if math.isfinite(mean) else math.inf

    return tuple(sorted(found, key=cost))
