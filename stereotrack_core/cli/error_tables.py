"""Tables of errors for people."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from stereotrack_core.cli.output import Table, number
from stereotrack_core.evaluation.accuracy import Accuracy
from stereotrack_core.evaluation.summary import Summary


def error_table(accuracy: Accuracy, title: str, frames_per_second: float | None = None) -> Table:
    """Mean, median and 95th percentile of every measure, and the share that is lost."""
    summary, doubts, quality = accuracy.summary, accuracy.doubts, accuracy.quality
    rows = measure_rows(summary)
    facts = {"lost (arm segments over 45 deg off) [%]": number(100.0 * summary.lost)}
    if doubts is not None:
        facts["failures flagged by the run that are real"] = f"{doubts.both} of {doubts.called}"
        facts["real failures flagged by the run"] = f"{doubts.both} of {doubts.lost}"
    facts |= {"frames": str(summary.frames), "frames not tracked": str(summary.not_tracked)}
    if frames_per_second is not None:
        facts["frames per second"] = number(frames_per_second)
    headings: tuple[str, ...] = ("measure", ">mean", ">median", ">95 %")
    if quality:
        headings = (*headings, ">reference uncertainty")
        good = [number(quality.get(measure.name, math.nan)) for measure in summary.measures]
        rows = [(*row, cell) for row, cell in zip(rows, good, strict=True)]
    blank = [""] * (len(headings) - 2)
    return Table(title, headings, [*rows, *((what, text, *blank) for what, text in facts.items())])


def measure_rows(summary: Summary) -> list[tuple[str, ...]]:
    """Label, mean, median and 95th percentile of every measure."""
    rows: list[tuple[str, ...]] = []
    for measure in summary.measures:
        figures = measure.statistics
        values = (figures.mean, figures.median, figures.p95)
        rows.append((f"{measure.label} [{measure.unit}]", *(number(value) for value in values)))
    return rows


def segment_table(summaries: Sequence[Summary]) -> Table:
    """Means of every segment, one row each."""
    headings = (
        *("segment", ">frames", ">torso mm", ">long", ">cross", ">upper arms", ">forearms"),
        *(">left upper", ">right upper", ">left fore", ">right fore", ">lost %"),
    )
    rows = [
        (
            summary.name,
            str(summary.frames),
            *(number(measure.statistics.mean) for measure in summary.measures),
            number(100.0 * summary.lost),
        )
        for summary in summaries
    ]
    return Table("Means per segment, degrees unless stated otherwise", headings, rows)


def accuracy_facts(accuracy: Accuracy) -> dict[str, Any]:
    """The same for JSON."""
    facts = error_facts(accuracy.summary)
    for name, good in accuracy.quality.items():
        facts["measures"][name]["reference_good_to"] = good
    if (doubts := accuracy.doubts) is not None:
        facts["lost_limbs"] = {
            "judged": doubts.judged,
            "lost": doubts.lost,
            "called_lost": doubts.called,
            "precision": doubts.precision,
            "recall": doubts.recall,
        }
    return facts


def error_facts(summary: Summary) -> dict[str, Any]:
    """Errors of one stretch for JSON."""
    return {
        "name": summary.name,
        "frames": summary.frames,
        "not_tracked": summary.not_tracked,
        "lost_percent": 100.0 * summary.lost,
        "measures": {
            measure.name: {"unit": measure.unit, **asdict(measure.statistics)}
            for measure in summary.measures
        },
    }
