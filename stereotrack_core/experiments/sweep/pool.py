"""Jobs done by processes of this machine, each on its share of the cores."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from stereotrack_core.errors import Cancelled
from stereotrack_core.experiments.sweep.batches import Batch, Batches
from stereotrack_core.experiments.sweep.jobs import Job
from stereotrack_core.experiments.sweep.results import JobResult
from stereotrack_core.experiments.sweep.watching import Watcher
from stereotrack_core.experiments.sweep.work import do_batch
from stereotrack_core.worker_processes import Asker, Lost, WorkerProcess, end, with_words

RETRIES = 1
"""How often a job is tried again whose failure may have been chance."""

_LOOK_SECONDS = 0.2


class _Worker(WorkerProcess):
    """A process, the batch that it is at, and the jobs of it that have no result yet."""

    def __init__(self, count: int) -> None:
        super().__init__(_do, count)
        self.batch = Batch(())
        self.open: dict[str, Job] = {}


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
        self._count = count
        self._together = together
        self._retries = retries
        self._workers: list[_Worker] = []

    def __enter__(self) -> LocalWorkers:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def count(self) -> int:
        """Jobs that are done at once."""
        return self._count

    @property
    def pids(self) -> tuple[int, ...]:
        """Process numbers of those at work."""
        return tuple(worker.pid for worker in self._workers if worker.pid is not None)

    def do(self, jobs: Sequence[Job], watcher: Watcher) -> None:
        """Do all jobs; returns when each has a result.

        Raises
        ------
        Cancelled
        """
        batches = Batches(jobs, self._count, self._together)
        while len(batches) or any(worker.open for worker in self._workers):
            self._hand_out(batches)
            self._listen(batches, watcher)
            if watcher.stopped():
                self.close()
                raise Cancelled

    def close(self) -> None:
        """End all processes at once; what they are at is lost."""
        end(self._workers)
        self._workers.clear()

    def _hand_out(self, batches: Batches) -> None:
        while len(batches):
            worker = next((one for one in self._workers if not one.busy), None)
            if worker is None:
                if len(self._workers) == self._count:
                    return
                worker = _Worker(self._count)
                self._workers.append(worker)
            batch = batches.next()
            if batch is None:
                return
            worker.batch = batch
            worker.open = {job.identity: job for job in batch.jobs}
            worker.give(batch.jobs)

    def _listen(self, batches: Batches, watcher: Watcher) -> None:
        for worker in with_words(self._workers, _LOOK_SECONDS):
            try:
                for word in worker.words():
                    self._heard(worker, word, batches, watcher)
            except Lost as lost:
                end([worker])
                self._workers.remove(worker)
                self._failed(worker, str(lost), batches, watcher)

    def _heard(self, worker: _Worker, word: Any, batches: Batches, watcher: Watcher) -> None:
        if isinstance(word, int):
            watcher.on_frames(word)
        elif isinstance(word, Exception):
            self._failed(worker, f"{type(word).__name__}: {word}", batches, watcher)
        else:
            self._ended(worker.open.pop(word.identity), word, worker.batch, batches, watcher)

    def _failed(self, worker: _Worker, why: str, batches: Batches, watcher: Watcher) -> None:
        """The batch has ended in the middle: its jobs are tried again, each alone."""
        for job in worker.open.values():
            result = JobResult(job.identity, "failed", error=why)
            self._ended(job, result, worker.batch, batches, watcher)
        worker.open = {}

    def _ended(
        self, job: Job, result: JobResult, batch: Batch, batches: Batches, watcher: Watcher
    ) -> None:
        if not result.done and not result.final and batch.tried < self._retries:
            batches.put_back(job, batch.tried + 1)
            return
        watcher.on_result(job, replace(result, attempts=batch.tried + 1))


def _do(jobs: Sequence[Job], asker: Asker) -> None:
    for result in do_batch(jobs, on_frames=asker.on_frames, cancelled=asker.gone):
        asker.tell(result)
