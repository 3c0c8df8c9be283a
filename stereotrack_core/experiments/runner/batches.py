"""Which jobs are done together, and which come first."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from stereotrack_core.experiments.runner.job import Job

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
    jobs : sequence of Job
    workers : int
    together : int, optional
        Largest batch; where not given, as large as is worth losing when the program is killed.
    """

    def __init__(self, jobs: Sequence[Job], workers: int, together: int | None = None) -> None:
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


def _cut(groups: Sequence[Sequence[Job]], workers: int, together: int | None) -> list[int]:
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
