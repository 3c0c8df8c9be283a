"""Which jobs are done together, and which come first."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from stereotrack_core.evaluation.sweeps.jobs import Job

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
    jobs : sequence of Job
    workers : int
    together : int
        Largest batch.
    """

    def __init__(self, jobs: Sequence[Job], workers: int, together: int) -> None:
        groups: dict[str, list[Job]] = {}
        for job in jobs:
            groups.setdefault(job.clouds, []).append(job)
        self._waiting = [
            Batch(tuple(group[i::count]))
            for group, count in zip(
                groups.values(), _cut(list(groups.values()), workers, together), strict=True
            )
            for i in range(count)
        ]
        self._waiting.sort(key=lambda batch: _work(batch.jobs), reverse=True)
        self._again: list[Batch] = []

    def __len__(self) -> int:
        return len(self._waiting) + len(self._again)

    def put_back(self, job: Job, tried: int) -> None:
        """Let a job be tried again."""
        self._again.append(Batch((job,), tried))

    def next(self) -> Batch | None:
        """The next batch; None where nothing waits."""
        for waiting in (self._waiting, self._again):
            if waiting:
                return waiting.pop(0)
        return None


def _cut(groups: Sequence[Sequence[Job]], workers: int, together: int) -> list[int]:
    """Into how many batches each group is cut."""
    fair = sum(_work(group) for group in groups) / workers
    counts = [
        max(math.ceil(len(group) / together), math.ceil(_work(group) / fair)) for group in groups
    ]
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
