"""Which jobs are done together, and which come first."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from stereotrack_core.evaluation.sweeps.jobs import Job


@dataclass(frozen=True)
class Batch:
    """Jobs that one process does together, and how often each was tried before."""

    jobs: tuple[Job, ...]
    tried: int = 0


class Batches:
    """Hands out jobs in batches that share their clouds.

    Batches are large at first, so that few clouds are made twice, and become small towards the
    end, so that no process waits long for another (guided self-scheduling,
    doi:10.1109/TC.1987.5009495). Jobs that are tried again come last and alone, so that one that
    ends its process takes no other with it.

    Parameters
    ----------
    jobs : sequence of Job
    workers : int
    together : int
        Largest batch.
    """

    def __init__(self, jobs: Sequence[Job], workers: int, together: int) -> None:
        self._groups: dict[str, list[Job]] = {}
        for job in jobs:
            self._groups.setdefault(job.clouds, []).append(job)
        self._again: list[Batch] = []
        self._workers = workers
        self._together = together

    def __len__(self) -> int:
        return sum(len(group) for group in self._groups.values()) + len(self._again)

    def put_back(self, job: Job, tried: int) -> None:
        """Let a job be tried again."""
        self._again.append(Batch((job,), tried))

    def next(self, clouds: str | None = None) -> Batch | None:
        """The next batch; None where nothing waits.

        Parameters
        ----------
        clouds : str, optional
            Clouds that the process has made last; those of others are left to others.
        """
        if not self._groups:
            return self._again.pop(0) if self._again else None
        name = clouds if clouds in self._groups else self._most_work()
        group = self._groups[name]
        waiting = sum(len(one) for one in self._groups.values())
        size = min(self._together, math.ceil(waiting / (2 * self._workers)), len(group))
        taken, left = group[:size], group[size:]
        if left:
            self._groups[name] = left
        else:
            del self._groups[name]
        return Batch(tuple(taken))

    def _most_work(self) -> str:
        def work(name: str) -> int:
            group = self._groups[name]
            return len(group) * len(group[0].frames) * len(group[0].views)

        return max(self._groups, key=work)
