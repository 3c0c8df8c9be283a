"""Jobs done by a Dask cluster, each under its identity as key."""

from __future__ import annotations

import queue
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import cv2

from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.experiments.runner.certificates import Certificates
from stereotrack_core.experiments.runner.job import (
    Job,
    JobResult,
    Watcher,
    do_batch,
    failure,
    recording_of,
)
from stereotrack_core.experiments.runner.local import RETRIES
from stereotrack_core.version import __version__
from stereotrack_core.versions import extra_library

_PATIENCE_SECONDS = 10.0
_LOOK_SECONDS = 0.2
_OUR_FAULT = "Use --workers to compute on this machine."


class ChanceError(Exception):
    """A job failed in a way that may not come again."""


class ClusterWorkers:
    """Workers of a Dask scheduler, who see the recordings by the same paths.

    The address is ``tcp://host:port``, or the path of a scheduler file (.json), whose answer is
    waited for some seconds. A worker that dies gives its jobs to others; results that were told are
    never asked again. Raises InputError where Dask is missing, nobody answers, or there is no
    worker.
    """

    def __init__(
        self,
        address: str,
        *,
        certificates: Certificates | None = None,
        retries: int = RETRIES,
        patience: float = _PATIENCE_SECONDS,
    ) -> None:
        distributed = extra_library(
            "distributed",
            "cluster",
            missing="Dask is not installed, which is needed for clusters",
            where="--scheduler",
            instead="--workers",
        )
        self._retries = retries
        where: dict[str, Any] = (
            {"scheduler_file": address} if address.endswith(".json") else {"address": address}
        )
        if certificates is not None:
            where["security"] = certificates.security(distributed)
        if "scheduler_file" in where and not Path(address).is_file():
            raise InputError(
                "the scheduler file was not found",
                where=f"--scheduler {address}",
                remedy=_OUR_FAULT,
            )
        try:
            self._client: Any = distributed.Client(**where, timeout=patience, set_as_default=False)
        except TypeError as error:  # what Dask raises where tls:// is asked for without them
            raise InputError(
                "this address needs certificates",
                where=f"--scheduler {address}",
                remedy="Give them with --tls-ca, --tls-cert and --tls-key, or in Dask's "
                "configuration.",
            ) from error
        except (OSError, TimeoutError, ValueError) as error:
            refused = "" if certificates is None else ", or it does not accept the certificates"
            raise InputError(
                f"no scheduler answers at this address{refused} ({error})",
                where=f"--scheduler {address}",
                remedy=f"Start one with `dask scheduler` and give its address. {_OUR_FAULT}",
            ) from None
        self._address = address

    def __enter__(self) -> ClusterWorkers:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def count(self) -> int:
        """Jobs that can be done at once."""
        return sum(self._client.nthreads().values())

    def check(self, jobs: Iterable[Job]) -> None:
        """Ask every worker whether it has this program and sees the recordings.

        Raises InputError that names the worker and what it lacks.
        """
        if not self._client.nthreads():
            raise InputError(
                "the scheduler has no worker",
                where=f"--scheduler {self._address}",
                remedy="Start one or more with `dask worker ADDRESS --nthreads 1`.",
            )
        wanted = {job.folder: job for job in jobs}
        told: Mapping[str, Any] = self._client.run(
            lacking, tuple(wanted.values()), __version__, on_error="return"
        )
        for worker, answer in told.items():
            if isinstance(answer, OSError):
                continue  # it has left the cluster while it was asked
            if isinstance(answer, BaseException):
                answer = f"the worker cannot run this program ({type(answer).__name__}: {answer})"
            if answer:
                raise InputError(
                    str(answer),
                    where=f"worker {worker}",
                    remedy="All machines must see the recordings under the same path. Keep them "
                    "on a shared drive, and install the same version everywhere.",
                )

    def do(self, jobs: Sequence[Job], watcher: Watcher) -> None:
        """Do all jobs; returns when each has a result."""
        self.check(jobs)
        ended: queue.SimpleQueue[Any] = queue.SimpleQueue()
        futures = {}
        for job in jobs:
            future = self._client.submit(
                do_job, job, key=job.identity, pure=False, retries=self._retries
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

    def close(self) -> None:
        """Leave the cluster; it goes on for others."""
        self._client.close()

    def _result(self, job: Job, future: Any) -> JobResult:
        error = future.exception()  # waits where a worker has died with what it had found
        if future.status == "cancelled":
            raise InputError(
                "the scheduler has stopped or lost the jobs",
                where=f"--scheduler {self._address}",
                remedy="Start it again and run the same command: finished results are kept.",
            )
        if error is None:
            result: JobResult = future.result()
            return result
        if isinstance(error, ChanceError):
            return JobResult(job.identity, "failed", error=str(error), attempts=self._retries + 1)
        return failure(job.identity, error, final=False)


def do_job(job: Job) -> JobResult:
    """Do one job on a worker.

    Raises ChanceError where it failed in a way that may not come again, so that Dask tries it
    again.
    """
    cv2.setNumThreads(1)  # the machine's other cores have workers of their own
    (result,) = do_batch((job,))
    if not result.done and not result.final:
        raise ChanceError(result.error)
    return result


def lacking(jobs: Sequence[Job], version: str) -> str:
    """What this machine lacks to do the jobs, in words; empty where nothing."""
    if version != __version__:
        return f"the worker has version {__version__} of this program, not {version}"
    for job in jobs:
        try:
            recording_of(job)
        except (InputError, OSError) as error:
            return f"the worker cannot use the recording {job.recording}: {error}"
    return ""
