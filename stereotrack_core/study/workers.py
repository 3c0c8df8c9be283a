"""Who does jobs: processes of this machine, or a Dask cluster."""

from __future__ import annotations

import math
import queue
import threading
from collections.abc import Sequence
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import cv2

from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.study.job import Job, JobResult, Watcher, do_batch, failure
from stereotrack_core.version import __version__
from stereotrack_core.versions import extra_library
from stereotrack_core.worker_processes import Asker, Lost, TaskProcess, usable_cores

_RETRIES = 1  # how often a job is tried again that may have failed by chance
_TOGETHER = 8  # jobs of a batch beyond which sharing their clouds saves little more
_MOST_FRAMES = 4000  # of all jobs of a batch: some ten minutes of work, which a kill may lose
_PATIENCE_SECONDS = 10.0
_LOOK_SECONDS = 0.2
_HERE_INSTEAD = "Use --workers to compute on this machine."


class LocalWorkers:
    """Processes of this machine, each on its share of the cores; they end with the block."""

    def __init__(self, count: int | None = None) -> None:
        self.count = count or usable_cores()
        """Jobs that are done at once."""
        self._processes = [TaskProcess(self.count, nice=0) for _ in range(self.count)]

    def __enter__(self) -> LocalWorkers:
        return self

    def __exit__(self, *_: object) -> None:
        for process in self._processes:
            process.close()

    def do(self, jobs: Sequence[Job], watcher: Watcher) -> None:
        """Do all jobs; returns when each has a result."""
        batches = Batches(jobs, self.count, watcher)
        with ThreadPoolExecutor(self.count) as threads:
            working = [threads.submit(batches.do, process) for process in self._processes]
            try:
                while wait(working, _LOOK_SECONDS, FIRST_EXCEPTION).not_done:
                    for one in working:
                        if one.done():
                            one.result()
                for one in working:
                    one.result()
            except BaseException:
                self.__exit__()  # who still works ends as well
                raise


def _do(batch: Batch, asker: Asker) -> str:
    """Tell the results of a batch; what ended it early, empty where nothing did."""
    try:
        for result in do_batch(batch.jobs, on_frames=asker.on_frames):
            asker.tell(result)
    except Exception as error:  # noqa: BLE001 - becomes the result of the jobs that are left
        return f"{type(error).__name__}: {error}"
    return ""


@dataclass(frozen=True)
class Batch:
    """Jobs that one process does together, and how often each was tried before."""

    jobs: tuple[Job, ...]
    tried: int = 0


class Batches:
    """Hands out jobs in batches that share their clouds, those with most work first.

    Neighbours in the plan go to different batches; jobs that are tried again come last and alone.
    """

    def __init__(self, jobs: Sequence[Job], workers: int, watcher: Watcher) -> None:
        self._watcher, self._telling = watcher, threading.Lock()
        self._open: dict[str, tuple[Job, int]] = {}
        self._again: list[Batch] = []
        groups: dict[str, list[Job]] = {}
        for job in jobs:
            groups.setdefault(job.clouds, []).append(job)
        share = _work(jobs) / workers
        self._waiting: list[Batch] = []
        for group in groups.values():
            count = _cuts(group, share)
            self._waiting += [Batch(tuple(group[i::count])) for i in range(count)]
        self._waiting.sort(key=lambda batch: _work(batch.jobs), reverse=True)

    def do(self, process: TaskProcess) -> None:
        """Have a process do batches until none waits; called in a thread for each process."""
        while (batch := self._next()) is not None:
            hear, stopped = self._hear, self._watcher.stopped
            try:
                why = process(partial(_do, batch), hear, stopped, listens=False)
            except Lost as lost:
                why = str(lost)
            with self._telling:
                self._failed(batch, why)

    def _next(self) -> Batch | None:
        with self._telling:
            waiting = self._waiting or self._again
            if not waiting:
                return None
            batch = waiting.pop(0)
            self._open |= {job.identity: (job, batch.tried) for job in batch.jobs}
            return batch

    def _hear(self, word: int | JobResult) -> None:
        """Take the frames that were done, or a result; of one process at a time."""
        with self._telling:
            if isinstance(word, int):
                self._watcher.on_frames(word)
            else:
                self._ended(word)

    def _failed(self, batch: Batch, why: str) -> None:
        for job in batch.jobs:
            if job.identity in self._open:
                self._ended(JobResult(job.identity, "failed", error=why))

    def _ended(self, result: JobResult) -> None:
        job, tried = self._open.pop(result.identity)
        if not result.done and not result.final and tried < _RETRIES:
            self._again.append(Batch((job,), tried + 1))
        else:
            self._watcher.on_result(job, replace(result, attempts=tried + 1))


def _cuts(group: Sequence[Job], share: float) -> int:
    """Into how many batches jobs are cut: none larger than allowed, or than a process's share."""
    largest = max(1, min(_TOGETHER, _MOST_FRAMES // len(group[0].frames)))
    return min(len(group), max(math.ceil(len(group) / largest), math.ceil(_work(group) / share)))


def _work(jobs: Sequence[Job]) -> int:
    """Images to go through, a measure of how long jobs take."""
    return sum(len(job.frames) * len(job.views) for job in jobs)


class ChanceError(Exception):
    """A job failed in a way that may not come again."""


class ClusterWorkers:
    """Workers of a Dask scheduler, who see the recordings by the same paths.

    The address is ``tcp://host:port``, ``tls://host:port``, or a scheduler file (.json). Raises
    InputError.
    """

    def __init__(self, address: str, *, patience: float = _PATIENCE_SECONDS) -> None:
        missing = "Dask is not installed, which is needed for clusters"
        distributed = extra_library(
            "distributed", "cluster", missing=missing, where="--scheduler", instead="--workers"
        )
        self._where = f"--scheduler {address}"
        by_file = address.endswith(".json")
        if by_file and not Path(address).is_file():
            raise InputError("the scheduler file was not found", self._where, _HERE_INSTEAD)
        named = {"scheduler_file" if by_file else "address": address}
        try:
            self._client: Any = distributed.Client(**named, timeout=patience, set_as_default=False)
        except (OSError, TimeoutError, TypeError, ValueError) as error:
            what = f"no scheduler answers at this address ({error})"
            remedy = f"Start one with `dask scheduler` and give its address. {_HERE_INSTEAD}"
            raise InputError(what, self._where, remedy) from None

    def __enter__(self) -> ClusterWorkers:
        return self

    def __exit__(self, *_: object) -> None:
        self._client.close()  # the cluster goes on for others

    @property
    def count(self) -> int:
        """Jobs that can be done at once."""
        return sum(self._client.nthreads().values())

    def do(self, jobs: Sequence[Job], watcher: Watcher) -> None:
        """Do all jobs; returns when each has a result."""
        if not self._client.nthreads():
            remedy = "Start one or more with `dask worker ADDRESS --nthreads 1`."
            raise InputError("the scheduler has no worker", self._where, remedy)
        ended: queue.SimpleQueue[Any] = queue.SimpleQueue()
        futures = {}
        for job in jobs:
            future = self._client.submit(
                do_job, job, __version__, key=job.identity, pure=False, retries=_RETRIES
            )
            futures[job.identity] = job, future
            future.add_done_callback(ended.put)
        try:
            while futures:
                if watcher.stopped():
                    raise Cancelled
                try:
                    future = ended.get(timeout=_LOOK_SECONDS)
                except queue.Empty:
                    continue
                job, _ = futures.pop(future.key)
                result = self._result(job, future)
                future.release()
                watcher.on_frames(len(job.frames))
                watcher.on_result(job, result)
        finally:
            self._client.cancel([future for _, future in futures.values()])

    def _result(self, job: Job, future: Any) -> JobResult:
        error = future.exception()  # waits if a worker has died with the result
        if future.status == "cancelled":
            remedy = "Start it again and run the same command: finished results are kept."
            raise InputError("the scheduler has stopped or lost the jobs", self._where, remedy)
        if error is None:
            result: JobResult = future.result()
            return result
        if isinstance(error, ChanceError):
            return JobResult(job.identity, "failed", error=str(error), attempts=_RETRIES + 1)
        return replace(failure(job.identity, error), final=False)


def do_job(job: Job, version: str) -> JobResult:
    """Do one job on a worker of a cluster, of the same version. Raises ChanceError."""
    if version != __version__:
        what = f"a worker has version {__version__} of this program, not {version}"
        error = InputError(what, remedy="Install the same version on all machines.")
        return failure(job.identity, error)
    cv2.setNumThreads(1)  # the machine's other cores have workers of their own
    (result,) = do_batch((job,))
    if not result.done and not result.final:
        raise ChanceError(result.error)
    return result
