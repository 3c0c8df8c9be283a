"""Tables of errors for people."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from stereotrack_core.cli.output import Table, number

if TYPE_CHECKING:
    from stereotrack_core.evaluation.doubts import Doubts
    from stereotrack_core.evaluation.summary import Summary


def error_table(
    summary: Summary,
    title: str,
    frames_per_second: float | None = None,
    doubts: Doubts | None = None,
    quality: Mapping[str, float] | None = None,
) -> Table:
    """Mean, median and 95th percentile of every measure, and the share that is lost.

    `quality` is how good the reference is, by measure (see :mod:`evaluation.reference_quality`).
    """
    rows = measure_rows(summary)
    rows.append(("lost (arm segments over 45 deg off) [%]", number(100.0 * summary.lost), "", ""))
    if doubts is not None:
        called = f"{doubts.both} of {doubts.called}"
        rows.append(("failures flagged by the run that are real", called, "", ""))
        rows.append(("real failures flagged by the run", f"{doubts.both} of {doubts.lost}", "", ""))
    rows.append(("frames", str(summary.frames), "", ""))
    rows.append(("frames not tracked", str(summary.not_tracked), "", ""))
    if frames_per_second is not None:
        rows.append(("frames per second", number(frames_per_second), "", ""))
    headings = ("measure", ">mean", ">median", ">95 %")
    if quality:
        names = [measure.name for measure in summary.measures]
        good = [number(quality.get(name, float("nan"))) for name in names]
        good += [""] * (len(rows) - len(good))
        rows = [(*row, cell) for row, cell in zip(rows, good, strict=True)]
        return Table(title, (*headings, ">reference uncertainty"), rows)
    return Table(title, headings, rows)


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


def doubt_facts(doubts: Doubts) -> dict[str, Any]:
    """How right a run is about which limbs are lost, for JSON."""
    return {
        "judged": doubts.judged,
        "lost": doubts.lost,
        "called_lost": doubts.called,
        "precision": doubts.precision,
        "recall": doubts.recall,
    }


def error_facts(summary: Summary, quality: Mapping[str, float] | None = None) -> dict[str, Any]:
    """The same for JSON."""
    facts: dict[str, Any] = {
        "name": summary.name,
        "frames": summary.frames,
        "not_tracked": summary.not_tracked,
        "lost_percent": 100.0 * summary.lost,
        "measures": {
            measure.name: {
                "unit": measure.unit,
                "mean": measure.statistics.mean,
                "median": measure.statistics.median,
                "p95": measure.statistics.p95,
                "count": measure.statistics.count,
            }
            for measure in summary.measures
        },
    }
    for name, good in (quality or {}).items():
        facts["measures"][name]["reference_good_to"] = good
    return facts
