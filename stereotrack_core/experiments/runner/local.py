"""Jobs done by processes of this machine, each on its share of the cores."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from stereotrack_core.experiments.runner.job import Job, JobResult, Watcher, do_batch
from stereotrack_core.worker_processes import Asker, Lost, Pool

RETRIES = 1
"""How often a job is tried again whose failure may have been chance."""


class LocalWorkers:
    """Processes that live from the first job until the end; see :class:`Batches`."""

    def __init__(self, count: int, *, together: int | None = None, retries: int = RETRIES) -> None:
        self._pool = Pool(_do, count)
        self._together = together
        self._retries = retries

    def __enter__(self) -> LocalWorkers:
        return self

    def __exit__(self, *_: object) -> None:
        self._pool.close()

    @property
    def count(self) -> int:
        """Jobs that are done at once."""
        return self._pool.count

    @property
    def pids(self) -> tuple[int, ...]:
        """Process numbers of those at work."""
        return tuple(worker.pid for worker in self._pool.workers if worker.pid is not None)

    def do(self, jobs: Sequence[Job], watcher: Watcher) -> None:
        """Do all jobs; returns when each has a result."""
        self._pool.work(Batches(jobs, self.count, self._together, watcher, self._retries))


def _do(batch: Batch, asker: Asker) -> None:
    for result in do_batch(batch.jobs, on_frames=asker.on_frames):
        asker.tell(result)


_TOGETHER = 8
"""Jobs beyond which sharing their clouds saves little more."""

_MOST_FRAMES = 4000
"""Frames of all jobs of a batch: some ten minutes of work."""

_FEW = 4
"""Batches per process from which it no longer matters whether they come out even."""


@dataclass(frozen=True)
class Batch:
    """Jobs that one process does together, and how often each was tried before."""

    jobs: tuple[Job, ...]
    tried: int = 0


class Batches:
    """Hands out jobs in batches that share their clouds.

    Jobs that share clouds are cut into as few batches as keep all processes busy: no larger than
    what one process may do together, none with more than one process's share of the work, and,
    where there are only few, as many as come out even. Jobs that stand beside each other in the
    plan, and cost about the same, go to different batches. Those with most work come first. Jobs
    that are tried again come last and alone, so that one that ends its process takes no other
    with it.

    Parameters
    ----------
    together : int, optional
        Largest batch; where not given, as large as is worth losing when the program is killed.
    watcher : Watcher
        Hears of everything; what may have failed by chance is tried again before.
    """

    def __init__(
        self,
        jobs: Sequence[Job],
        workers: int,
        together: int | None,
        watcher: Watcher,
        retries: int = RETRIES,
    ) -> None:
        self._watcher, self._retries = watcher, retries
        self.stopped = watcher.stopped
        self._open: dict[str, tuple[Job, int]] = {}
        groups: dict[str, list[Job]] = {}
        for job in jobs:
            groups.setdefault(job.clouds, []).append(job)
        self._waiting = [
            Batch(tuple(group[i::count]))
            for group, count in zip(
                groups.values(), _cut_counts(list(groups.values()), workers, together), strict=True
            )
            for i in range(count)
        ]
        self._waiting.sort(key=lambda batch: _work(batch.jobs), reverse=True)
        self._again: list[Batch] = []

    def next(self) -> Batch | None:
        """The next batch; None where nothing waits."""
        waiting = self._waiting or self._again
        if not waiting:
            return None
        batch = waiting.pop(0)
        self._open |= {job.identity: (job, batch.tried) for job in batch.jobs}
        return batch

    def heard(self, batch: Batch, word: Any) -> None:
        """Take the frames that were done, a result, or what the batch failed of."""
        if isinstance(word, int):
            self._watcher.on_frames(word)
        elif isinstance(word, Exception):
            self._failed(batch, f"{type(word).__name__}: {word}")
        else:
            self._ended(word)

    def lost(self, batch: Batch, why: Lost) -> None:
        """Its process has ended by itself."""
        self._failed(batch, str(why))

    def ended(self, batch: Batch) -> None:
        """Each of its jobs has told its result."""

    def _failed(self, batch: Batch, why: str) -> None:
        """The batch has ended in the middle: its jobs are tried again, each alone."""
        for job in batch.jobs:
            if job.identity in self._open:
                self._ended(JobResult(job.identity, "failed", error=why))

    def _ended(self, result: JobResult) -> None:
        job, tried = self._open.pop(result.identity)
        if not result.done and not result.final and tried < self._retries:
            self._again.append(Batch((job,), tried + 1))
        else:
            self._watcher.on_result(job, replace(result, attempts=tried + 1))


def _cut_counts(groups: Sequence[Sequence[Job]], workers: int, together: int | None) -> list[int]:
    """Into how many batches each group is cut."""
    fair = sum(_work(group) for group in groups) / workers
    counts = []
    for group in groups:
        largest = together or max(1, min(_TOGETHER, _MOST_FRAMES // len(group[0].frames)))
        counts.append(max(math.ceil(len(group) / largest), math.ceil(_work(group) / fair)))
    counts = [min(count, len(group)) for count, group in zip(counts, groups, strict=True)]
    while sum(counts) % workers and sum(counts) < _FEW * workers:
        can = [i for i, group in enumerate(groups) if counts[i] < len(group)]
        if not can:
            break
        counts[max(can, key=lambda i: _work(groups[i]) / counts[i])] += 1
    return counts


def _work(jobs: Sequence[Job]) -> int:
    """Images that have to be gone through, which tells about how long jobs take."""
    return len(jobs) * len(jobs[0].frames) * len(jobs[0].views)
