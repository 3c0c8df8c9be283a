"""Doing a sweep: what is known is not computed again, what becomes known is kept at once."""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.evaluation.summary import Spread
from stereotrack_core.experiments.measures import MEASURES, measure_named
from stereotrack_core.experiments.runner.job import Executor, Job, JobResult, is_kept
from stereotrack_core.experiments.sweep.plan import SweepPlan
from stereotrack_core.experiments.sweep.points import Point, Search
from stereotrack_core.experiments.sweep.store import Ending, SweepState, SweepStore

_STATE_SECONDS = 0.5
_TABLE_SECONDS = 5.0


@dataclass(frozen=True)
class SweepOutcome:
    """How a sweep ended."""

    jobs: tuple[Job, ...]
    """All that were wanted."""
    reused: int
    """Different jobs whose results were there already."""
    computed: int
    """Jobs computed by this command."""
    stopped: bool


class SweepRun:
    """One command's work on a sweep.

    `on_percent` is told how much of the work is done, and `cancelled` asked whether to stop;
    whoever else wants that says so by the store.
    """

    def __init__(
        self,
        plan: SweepPlan,
        store: SweepStore,
        executor: Executor,
        *,
        on_percent: Callable[[int], None] = lambda _: None,
        cancelled: Callable[[], bool] = lambda: False,
    ) -> None:
        self._plan = plan
        self._store = store
        self._executor = executor
        self._on_percent = on_percent
        self._cancelled = cancelled
        self._jobs: list[Job] = []
        self._fresh: set[str] = set()
        self._reused: set[str] = set()
        self._failed = 0
        self._frames = _Frames()
        self._stopped = False
        self._table_told = self._state_told = 0.0

    def do(self) -> SweepOutcome:
        """Compute what is missing; leaves table and state behind, however it ends."""
        with self._working():
            if self._plan.ranges:
                self._search()
            else:
                waiting = self._waiting(self._plan.jobs)
                self._frames.expect(sum(len(job.frames) for job in waiting))
                self._do(self._plan.jobs)
        reused, computed = len(self._reused), len(self._fresh)
        return SweepOutcome(tuple(self._jobs), reused, computed, self._stopped)

    def _search(self) -> None:
        """Look for the point that is best by a measure."""
        plan, request = self._plan, self._plan.request
        at_once = plan.search_batch(self._executor.count)
        batch = self._store.search_batch(plan.search_signature(), at_once)
        measure = measure_named(plan.by)
        more = measure is not None and measure.more_is_better
        search = Search(plan.ranges, request.search_seed, more_is_better=more)
        tried = 0
        while tried < request.trials:
            points = search.ask(min(batch, request.trials - tried))
            jobs = plan.jobs_of(points)
            frames = sum(len(job.frames) for job in jobs)
            rounds = math.ceil((request.trials - tried) / len(points))
            self._frames.expect(frames * rounds)
            self._do(jobs)
            search.tell([self._value(jobs, point) for point in points])
            tried += len(points)

    # ---- what the executor tells and asks

    def on_frames(self, count: int) -> None:
        """So many frames more were tracked."""
        self._frames.add(count)
        self._on_percent(int(100 * self._frames.share))
        self._note()

    def on_result(self, job: Job, result: JobResult) -> None:
        """Keep a result."""
        self._store.keep(job, result)
        self._fresh.add(job.identity)
        self._failed += not result.done
        self._note()

    def stopped(self) -> bool:
        """Whether to stop."""
        return self._cancelled() or self._store.stop_asked()

    # ---- inside

    def _do(self, jobs: Sequence[Job]) -> None:
        waiting = self._waiting(jobs)
        missing = {job.identity for job in waiting}
        self._jobs += jobs
        self._reused |= {job.identity for job in jobs} - missing - self._fresh
        self._note(now=True)
        if waiting:
            self._executor.do(waiting, self)

    def _waiting(self, jobs: Sequence[Job]) -> list[Job]:
        """Jobs to be computed, each once; those that failed in earlier commands are tried again."""
        wanted: dict[str, Job] = {}
        for job in jobs:
            result = self._store.results.get(job.identity)
            fresh = job.identity in self._fresh
            known = result is not None and (fresh or (result.done and is_kept(job)))
            if not known or (self._plan.request.again and not fresh):
                wanted.setdefault(job.identity, job)
        return list(wanted.values())

    def _value(self, jobs: Sequence[Job], point: Point) -> float:
        """How good a point is; NaN where any of its runs failed."""
        by = self._plan.by
        own = [job for job in jobs if job.point == point]
        found = summarised(own, self._store.results, by)
        if len(found) != 1 or found[0].failed:
            return math.nan
        value = found[0].values[by].mean
        return value if math.isfinite(cost(found[0], by)) else math.nan

    @contextlib.contextmanager
    def _working(self) -> Iterator[None]:
        """Leave table and state behind, also where the work is stopped or fails."""
        ended: Ending = "failed"
        error = ""
        try:
            yield
            ended = "done"
        except Cancelled:
            self._stopped = True
            ended = "stopped"
        except InputError as wrong:
            error = str(wrong)
            raise
        finally:
            self._store.write_table(self._jobs)
            self._store.note_state(self._state(ended, error))

    def _note(self, *, now: bool = False) -> None:
        """Say how it is going, not all too often."""
        moment = time.monotonic()
        if now or moment - self._state_told > _STATE_SECONDS:
            self._state_told = moment
            self._store.note_state(self._state("", ""))
        if moment - self._table_told > _TABLE_SECONDS:
            self._table_told = moment
            self._store.write_table(self._jobs)

    def _state(self, ended: Ending, error: str) -> SweepState:
        whole = ended == "done"
        return SweepState(
            jobs=len({job.identity for job in self._jobs}),
            reused=len(self._reused),
            computed=len(self._fresh),
            failed=self._failed,
            share=1.0 if whole else self._frames.share,
            seconds_left=0.0 if ended else self._frames.seconds_left(),
            ended=ended,
            error=error,
        )


class _Frames:
    """Frames tracked, wanted, and the time that is left."""

    def __init__(self) -> None:
        self._done = 0
        self._wanted = 0
        self._first: tuple[float, int] | None = None

    def expect(self, more: int) -> None:
        """So many are wanted from now on."""
        self._wanted = self._done + more

    def add(self, count: int) -> None:
        """So many more are done; those that are done again do not count twice."""
        self._done = min(self._done + count, max(self._wanted, self._done))
        if self._first is None:
            self._first = time.monotonic(), self._done

    @property
    def share(self) -> float:
        """Of the work, 0 to 1."""
        return self._done / self._wanted if self._wanted else 0.0

    def seconds_left(self) -> float | None:
        """At the pace since the first frames were done; None before there is a pace."""
        if self._first is None:
            return None
        begun, before = self._first
        seconds, done = time.monotonic() - begun, self._done - before
        return seconds / done * (self._wanted - self._done) if done else None


@dataclass(frozen=True)
class PointSummary:
    """All recordings and seeds of one point together."""

    point: Point
    """Without its seed."""
    runs: int
    """Runs that gave something."""
    failed: int
    values: Mapping[str, Spread]
    """By measure, over the runs."""


def summarised(
    jobs: Iterable[Job], results: Mapping[str, JobResult], by: str
) -> tuple[PointSummary, ...]:
    """Summaries of all points of which something is known, those best by a measure first."""
    groups: dict[Point, list[JobResult]] = {}
    for job in jobs:
        if job.identity in results:
            point = Point(tuple(one for one in job.point.values if one[0] != "seed"))
            groups.setdefault(point, []).append(results[job.identity])
    found = []
    for point, own in groups.items():
        good = [result.measures for result in own if result.done]
        values = {
            measure.name: Spread.of(one.get(measure.name, math.nan) for one in good)
            for measure in MEASURES
        }
        found.append(PointSummary(point, len(good), len(own) - len(good), values))
    return tuple(sorted(found, key=lambda one: cost(one, by)))


def cost(summary: PointSummary, by: str) -> float:
    """What a point is sorted by: small is good; a point that gave nothing comes last."""
    value = summary.values[by].mean if by in summary.values else math.nan
    measure = measure_named(by)
    if not math.isfinite(value):
        return math.inf
    return -value if measure is not None and measure.more_is_better else value
