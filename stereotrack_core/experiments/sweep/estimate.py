"""How long a sweep will take, from what its jobs took before."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from statistics import fmean

from stereotrack_core.experiments.runner.job import Job, JobResult


def expected_seconds(
    waiting: Iterable[Job], known: Iterable[Job], results: Mapping[str, JobResult], workers: int
) -> float | None:
    """Wall time that jobs will take; None where none has been measured yet.

    A job takes per frame what jobs on the same views of the same recording took, else what all
    took per frame and view.

    Parameters
    ----------
    waiting : iterable of Job
        What is still to be done.
    known : iterable of Job
        Jobs of which some have results.
    results : mapping from identity to JobResult
    workers : int
        Jobs that are done at once.
    """
    same: dict[tuple[str, int], list[float]] = {}
    per_view: list[float] = []
    for job in known:
        result = results.get(job.identity)
        seconds = result.measures.get("seconds") if result is not None and result.done else None
        if seconds is not None and len(job.frames):
            each = seconds / len(job.frames)
            same.setdefault((job.folder, len(job.views)), []).append(each)
            per_view.append(each / len(job.views))
    if not per_view:
        return None
    total = 0.0
    for job in waiting:
        own = same.get((job.folder, len(job.views)))
        each = fmean(own) if own else fmean(per_view) * len(job.views)
        total += each * len(job.frames)
    return total / max(1, workers)
