"""Jobs done by processes of this machine, each on its share of the cores."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from stereotrack_core.experiments.runner.batches import Batch, Batches
from stereotrack_core.experiments.runner.job import Job, JobResult, Watcher
from stereotrack_core.experiments.runner.work import do_batch
from stereotrack_core.worker_processes import Asker, Lost, Pool

RETRIES = 1
"""How often a job is tried again whose failure may have been chance."""


class LocalWorkers:
    """Processes that are started with the first job and live until the end.

    Parameters
    ----------
    count : int
        Processes.
    together : int, optional
        Jobs that one process does together, at most; see :class:`Batches`.
    retries : int
    """

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
        """Do all jobs; returns when each has a result.

        Raises
        ------
        Cancelled
        """
        batches = Batches(jobs, self.count, self._together)
        self._pool.work(_JobDesk(batches, watcher, self._retries))


class _JobDesk:
    """Hands out batches, and tries again what may have failed by chance."""

    def __init__(self, batches: Batches, watcher: Watcher, retries: int) -> None:
        self._batches, self._watcher, self._retries = batches, watcher, retries
        self._open: dict[str, tuple[Job, int]] = {}
        self.stopped = watcher.stopped

    def next(self) -> Batch | None:
        batch = self._batches.next()
        for job in () if batch is None else batch.jobs:
            self._open[job.identity] = job, 0 if batch is None else batch.tried
        return batch

    def heard(self, batch: Batch, word: Any) -> None:
        if isinstance(word, int):
            self._watcher.on_frames(word)
        elif isinstance(word, Exception):
            self._failed(batch, f"{type(word).__name__}: {word}")
        else:
            self._ended(word)

    def lost(self, batch: Batch, why: Lost) -> None:
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
            self._batches.put_back(job, tried + 1)
            return
        self._watcher.on_result(job, replace(result, attempts=tried + 1))


def _do(batch: Batch, asker: Asker) -> None:
    for result in do_batch(batch.jobs, on_frames=asker.on_frames, cancelled=asker.gone):
        asker.tell(result)
