"""What the runs of each point come to together."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from stereotrack_core.experiments.measures import MEASURES, measure_named
from stereotrack_core.experiments.runner.job import Job, JobResult
from stereotrack_core.experiments.sweep.points import Point


@dataclass(frozen=True)
class PointSummary:
    """All recordings and seeds of one point together.

    Attributes
    ----------
    point : Point
        Without its seed.
    runs : int
        Runs that gave something.
    failed : int
    mean, spread : mapping from measure to float
        Mean and standard deviation over the runs; NaN where there are none, or only one.
    """

    point: Point
    runs: int
    failed: int
    mean: Mapping[str, float]
    spread: Mapping[str, float]


def summarised(
    jobs: Iterable[Job], results: Mapping[str, JobResult], by: str
) -> tuple[PointSummary, ...]:
    """Summaries of all points of which something is known, best first.

    Parameters
    ----------
    jobs : iterable of Job
    results : mapping from identity to JobResult
    by : str
        Measure that says which one is best.
    """
    groups: dict[Point, list[JobResult]] = {}
    for job in jobs:
        if job.identity in results:
            point = Point(tuple(one for one in job.point.values if one[0] != "seed"))
            groups.setdefault(point, []).append(results[job.identity])
    found = [_summary(point, own) for point, own in groups.items()]
    return tuple(sorted(found, key=lambda one: cost(one, by)))


def cost(summary: PointSummary, by: str) -> float:
    """What a point is sorted by: small is good; a point that gave nothing comes last."""
    value = summary.mean.get(by, float("nan"))
    measure = measure_named(by)
    if not math.isfinite(value):
        return math.inf
    return -value if measure is not None and measure.more_is_better else value


def _summary(point: Point, results: list[JobResult]) -> PointSummary:
    good = [result.measures for result in results if result.done]
    mean, spread = {}, {}
    for measure in MEASURES:
        values = np.array([own[measure.name] for own in good if measure.name in own])
        values = values[np.isfinite(values)]
        mean[measure.name] = float(values.mean()) if values.size else float("nan")
        spread[measure.name] = float(values.std(ddof=1)) if values.size > 1 else float("nan")
    return PointSummary(point, len(good), len(results) - len(good), mean, spread)
