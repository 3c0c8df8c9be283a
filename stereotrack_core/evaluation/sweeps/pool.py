"""Jobs done by processes of this machine, each on its share of the cores."""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from typing import Any

import cv2

from stereotrack_core.blas_threads import one_blas_thread
from stereotrack_core.errors import Cancelled
from stereotrack_core.evaluation.sweeps.batches import Batch, Batches
from stereotrack_core.evaluation.sweeps.jobs import Job
from stereotrack_core.evaluation.sweeps.results import JobResult
from stereotrack_core.evaluation.sweeps.watching import Watcher
from stereotrack_core.evaluation.sweeps.work import do_batch

RETRIES = 1
"""How often a job is tried again whose failure may have been chance."""

_LOOK_SECONDS = 0.2
_TELL_SECONDS = 0.2
_LAST_WORD_SECONDS = 5.0
_CONTEXT = multiprocessing.get_context("spawn")


def usable_cores() -> int:
    """Cores that this program may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@dataclass(eq=False)
class _Worker:
    """A process, what it is at, and how to talk with it."""

    process: SpawnProcess
    pipe: Connection
    batch: Batch | None = None
    open: dict[str, Job] = field(default_factory=dict)


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
        return tuple(w.process.pid for w in self._workers if w.process.pid is not None)

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
        for worker in self._workers:
            worker.process.terminate()
        for worker in self._workers:
            worker.process.join(_LAST_WORD_SECONDS)
            if worker.process.is_alive():
                worker.process.kill()
                worker.process.join()
            worker.pipe.close()
        self._workers.clear()

    def _hand_out(self, batches: Batches) -> None:
        while len(batches):
            worker = next((one for one in self._workers if one.batch is None), None)
            if worker is None:
                if len(self._workers) == self._count:
                    return
                worker = _started(self._count)
                self._workers.append(worker)
            batch = batches.next()
            if batch is None:
                return
            worker.batch = batch
            worker.open = {job.identity: job for job in batch.jobs}
            try:
                worker.pipe.send(batch.jobs)
            except (BrokenPipeError, ConnectionResetError):
                continue  # it has died; listening to it finds out

    def _listen(self, batches: Batches, watcher: Watcher) -> None:
        by_pipe = {worker.pipe: worker for worker in self._workers}
        for pipe in wait(list(by_pipe), _LOOK_SECONDS):
            worker = by_pipe[pipe]  # type: ignore[index]  # only pipes were waited for
            try:
                while worker.pipe.poll():
                    self._heard(worker, worker.pipe.recv(), batches, watcher)
            except (EOFError, ConnectionResetError):
                self._lost(worker, batches, watcher)

    def _heard(self, worker: _Worker, word: Any, batches: Batches, watcher: Watcher) -> None:
        assert worker.batch is not None  # noqa: S101 - it talks about its batch alone
        if isinstance(word, int):
            watcher.on_frames(word)
        elif isinstance(word, JobResult):
            self._ended(worker.open.pop(word.identity), word, worker.batch, batches, watcher)
        else:
            worker.batch = None

    def _ended(
        self, job: Job, result: JobResult, batch: Batch, batches: Batches, watcher: Watcher
    ) -> None:
        if not result.done and not result.final and batch.tried < self._retries:
            batches.put_back(job, batch.tried + 1)
            return
        watcher.on_result(job, replace(result, attempts=batch.tried + 1))

    def _lost(self, worker: _Worker, batches: Batches, watcher: Watcher) -> None:
        """A process has ended in the middle: its jobs are tried again, each alone."""
        worker.process.join(_LAST_WORD_SECONDS)
        code = worker.process.exitcode
        worker.pipe.close()
        self._workers.remove(worker)
        for job in worker.open.values():
            assert worker.batch is not None  # noqa: S101 - it has open jobs
            words = f"the process that tracked it has ended by itself (exit code {code})"
            result = JobResult(job.identity, "failed", error=words)
            self._ended(job, result, worker.batch, batches, watcher)


def _started(count: int) -> _Worker:
    own, theirs = _CONTEXT.Pipe()
    threads = max(1, usable_cores() // count)
    process = _CONTEXT.Process(target=_serve, args=(theirs, threads), daemon=True)
    with _environment(OPENBLAS_NUM_THREADS="1", OMP_NUM_THREADS="1", MKL_NUM_THREADS="1",
                      NUMBA_NUM_THREADS=str(threads)):  # fmt: skip
        process.start()
    theirs.close()
    return _Worker(process, own)


@contextmanager
def _environment(**values: str) -> Iterator[None]:
    """Set variables that a process inherits: libraries look at them when they are loaded."""
    before = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _serve(pipe: Connection, threads: int) -> None:
    """Do batches until nobody asks any more, or whoever asked is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the one who asked
    cv2.setNumThreads(threads)
    parent = multiprocessing.parent_process()
    teller = _Teller(pipe)

    def orphaned() -> bool:
        return parent is not None and not parent.is_alive()

    with one_blas_thread():
        try:
            while True:
                jobs = pipe.recv()
                for result in do_batch(jobs, on_frames=teller.count, cancelled=orphaned):
                    teller.flush()
                    pipe.send(result)
                teller.flush()
                pipe.send(None)
        except (EOFError, OSError, Cancelled):
            return


class _Teller:
    """Tells how many frames were tracked, some times a second."""

    def __init__(self, pipe: Connection) -> None:
        self._pipe = pipe
        self._untold = 0
        self._told = 0.0

    def count(self, frames: int) -> None:
        self._untold += frames
        if time.monotonic() - self._told > _TELL_SECONDS:
            self.flush()

    def flush(self) -> None:
        if self._untold:
            self._pipe.send(self._untold)
            self._untold, self._told = 0, time.monotonic()
