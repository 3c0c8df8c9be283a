"""What a sweep prints: a row per point, best first."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from stereotrack_core.cli.output import Table, number
from stereotrack_core.experiments.measures import MEASURES, SweepMeasure, measure_named
from stereotrack_core.experiments.runner.job import Job, JobResult
from stereotrack_core.experiments.sweep.points import Point, varied_names
from stereotrack_core.experiments.sweep.summary import PointSummary

_WITH_TRUTH = ("torso_position", "upper_arms", "forearms", "lost", "not_tracked")
_WITHOUT = ("gaps", "unexplained_fraction", "residual", "limb_sigma", "limb_lost")
_MOST_ROWS = 40


def point_table(summaries: Sequence[PointSummary], by: str) -> Table:
    """Mean and spread of every point over recordings and seeds, best first."""
    varied = varied_names(summary.point for summary in summaries)
    known = any(math.isfinite(one.mean["forearms"]) for one in summaries)
    names = dict.fromkeys((by, *(_WITH_TRUTH if known else _WITHOUT), "frames_per_second"))
    measures = [measure for name in names if (measure := measure_named(name)) is not None]
    rows = [_row(summary, varied, measures) for summary in summaries[:_MOST_ROWS]]
    more = len(summaries) - len(rows)
    judged = (measures[0].short or measures[0].label) if measures else by
    title = f"Mean ± standard deviation over recordings and seeds, best {judged} first"
    if more > 0:
        title += f"; {more} more points are in the table"
    return Table(title, (*varied, ">runs", *(f">{_brief(measure)}" for measure in measures)), rows)


def _row(
    summary: PointSummary, varied: Sequence[str], measures: Sequence[SweepMeasure]
) -> list[str]:
    values = summary.point.by_name
    runs = str(summary.runs) + (f", {summary.failed} failed" if summary.failed else "")
    cells = [_figure(summary, measure) for measure in measures]
    return [*(text_of(values.get(name, "")) for name in varied), runs, *cells]


def _figure(summary: PointSummary, measure: SweepMeasure) -> str:
    mean, spread = summary.mean[measure.name], summary.spread[measure.name]
    return number(mean) + (f" ± {number(spread)}" if math.isfinite(spread) else "")


def _brief(measure: SweepMeasure) -> str:
    return f"{measure.short or measure.label} {measure.unit}".strip()


def text_of(value: object) -> str:
    """A value as a person types it."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:g}" if isinstance(value, float) else str(value)


def point_facts(summary: PointSummary) -> dict[str, Any]:
    """The same for JSON."""
    return {
        "values": summary.point.by_name,
        "runs": summary.runs,
        "failed": summary.failed,
        "mean": _known(summary.mean),
        "standard_deviation": _known(summary.spread),
    }


def _known(values: Mapping[str, float]) -> dict[str, float]:
    return {m.name: values[m.name] for m in MEASURES if math.isfinite(values[m.name])}


def failures(jobs: Sequence[Job], results: Mapping[str, JobResult]) -> list[str]:
    """What went wrong, once for each kind of error, with the number of its jobs."""
    found: dict[str, list[Job]] = {}
    for job in {job.identity: job for job in jobs}.values():
        result = results.get(job.identity)
        if result is not None and not result.done:
            found.setdefault(result.error, []).append(job)
    lines = []
    for error, own in found.items():
        first = own[0]
        which = f"{first.recording}, {_named(first.point)}seed {first.seed}"
        more = f" and {len(own) - 1} more" if len(own) > 1 else ""
        lines.append(f"Failed: {which}{more}: {error}")
    return lines


def _named(point: Point) -> str:
    return "".join(f"{name}={text_of(value)}, " for name, value in point.values if name != "seed")
