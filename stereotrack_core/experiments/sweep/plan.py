"""What a sweep comes to, checked before anything long begins."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from stereotrack_core.errors import InputError, did_you_mean
from stereotrack_core.experiments.measures import MEASURES, measure_named
from stereotrack_core.experiments.runner.job import Job, JobResult
from stereotrack_core.experiments.sweep.estimate import expected_seconds
from stereotrack_core.experiments.sweep.jobs import Planner
from stereotrack_core.experiments.sweep.points import (
    Point,
    grid_points,
    listed_points,
    parsed_axis,
)
from stereotrack_core.experiments.sweep.request import SweepRequest
from stereotrack_core.experiments.sweep.search import Search, parsed_range
from stereotrack_core.recording.csv_table import read_csv_table
from stereotrack_core.recording.description import Recording


class SweepPlan:
    """What a request asks for: jobs, or ranges in which points are searched.

    Parameters
    ----------
    request : SweepRequest
    recordings : sequence of Recording
        Its recordings, opened.

    Attributes
    ----------
    by : str
        Measure that says which point is best.
    ranges : tuple of Range
        Where a search looks; empty where there is no search.
    jobs : tuple of Job
        Empty for a search, whose points depend on what comes out.

    Raises
    ------
    InputError
        Where something cannot be meant.
    """

    def __init__(self, request: SweepRequest, recordings: Sequence[Recording]) -> None:
        self.request = request
        self.by = _judged_by(request.minimise, recordings)
        self.planner = Planner(recordings, request)
        self.ranges = tuple(parsed_range(text) for text in request.search)
        self.jobs = () if self.ranges else self.planner.jobs(_points(request))

    def jobs_to_count(self) -> tuple[Job, ...]:
        """All jobs; of a search as many as it will try."""
        if not self.ranges:
            return self.jobs
        search = Search(self.ranges, self.request.search_seed)
        return self.planner.jobs(search.ask(self.request.trials))

    def search_batch(self, at_once: int) -> int:
        """Points that a search asks for at once, so that nobody has to wait for work."""
        return max(1, math.ceil(at_once / (len(self.request.recordings) * len(self.planner.seeds))))

    def search_signature(self) -> str:
        """Hash by which a search is known again."""
        text = repr((self.ranges, self.by, self.request.search_seed))
        return hashlib.blake2b(text.encode(), digest_size=8).hexdigest()


@dataclass(frozen=True)
class SweepCount:
    """What a sweep would compute.

    Attributes
    ----------
    jobs : int
        Different runs in all.
    points : int
    there : int
        Jobs that are in the table already.
    frames : int
        Frames of the others.
    workers : int
        Jobs that are done at once.
    seconds : float or None
        What the others will take, from what was computed before; None where nothing was.
    """

    jobs: int
    points: int
    there: int
    frames: int
    workers: int
    seconds: float | None


def count_of(
    jobs: Sequence[Job], known: Mapping[str, JobResult], workers: int
) -> tuple[SweepCount, list[Job]]:
    """What a sweep would compute, and the jobs of it."""
    different = {job.identity: job for job in jobs}
    waiting = [job for one, job in different.items() if one not in known or not known[one].done]
    seconds = expected_seconds(waiting, jobs, known, workers) if waiting else 0.0
    count = SweepCount(
        jobs=len(different),
        points=len({job.point for job in jobs}),
        there=len(different) - len(waiting),
        frames=sum(len(job.frames) for job in waiting),
        workers=workers,
        seconds=seconds,
    )
    return count, waiting


def _points(request: SweepRequest) -> tuple[Point, ...]:
    """Points of a grid or a list; one that changes nothing where there is neither."""
    if request.points is not None:
        columns, rows = read_csv_table(request.points)
        return listed_points(columns, rows, str(request.points))
    return grid_points([parsed_axis(text) for text in request.grid])


def _judged_by(asked: str | None, recordings: Sequence[Recording]) -> str:
    """Measure that says which point is best.

    Raises
    ------
    InputError
        For an unknown one, or one that needs a reference that is not there.
    """
    without = [one for one in recordings if one.reference is None]
    if asked is None:
        return "unexplained_fraction" if without else "forearms"
    measure = measure_named(asked)
    if measure is None:
        names = [one.name for one in MEASURES]
        raise InputError(
            f"unknown measure {asked!r}",
            where="--minimise",
            remedy=f"{did_you_mean(asked, names)}Available: {', '.join(names)}.",
        )
    if measure.from_reference and without:
        raise InputError(
            f"{asked} needs a reference, which {without[0].name} does not have",
            where="--minimise",
            remedy="Choose unexplained_fraction, or recordings with a reference.csv.",
        )
    return asked
