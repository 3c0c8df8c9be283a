"""What whoever does jobs is told and asks, whether on this machine or on a cluster."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from stereotrack_core.experiments.sweep.jobs import Job
from stereotrack_core.experiments.sweep.results import JobResult


class Watcher(Protocol):
    """Hears of everything that happens; called in the thread that asked for the jobs."""

    def on_frames(self, count: int) -> None:
        """So many frames more were tracked."""

    def on_result(self, job: Job, result: JobResult) -> None:
        """A job has come to its end; called once for each."""

    def stopped(self) -> bool:
        """Whether to stop."""


class Executor(Protocol):
    """Does jobs."""

    @property
    def count(self) -> int:
        """Jobs that are done at once."""

    def do(self, jobs: Sequence[Job], watcher: Watcher) -> None:
        """Do all jobs, whose identities differ; returns when each has a result.

        Raises
        ------
        Cancelled
            When the watcher wants to stop; results that were told stay valid.
        """
