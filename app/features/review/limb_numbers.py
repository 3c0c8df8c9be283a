"""Statistics of the limbs of runs: over the selection or the whole, and over every segment."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.evaluation.summary import ALL_ARMS, LimbStatistics, limb_statistics
from stereotrack_core.recording.description import Segment
from stereotrack_core.tables import csv_text

from ...session.judgement import LOST_SHARE, MEASURED_LIMBS, Judgement
from ...session.runs import RunEntry
from ...widgets.style.limb_colours import LIMB_COLOURS, limb_words
from ...widgets.tables.table import RIGHT, Cell, CellRow, Column
from ...widgets.tables.trees import TreeRow

LOST_DEG = 45.0
_CSV = (
    "run", "stretch", "first", "end", "limb", "measure", "frames", "mean_deg", "median_deg",
    "p95_deg", "maximum_deg", "threshold_deg", "above_threshold_percent", "lost_percent",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class StretchNumbers:
    """Statistics of one run in one stretch of frames."""

    run: str
    stretch: Segment
    measure: str
    """What the numbers are of, in words."""
    limbs: tuple[LimbStatistics, ...]
    """Degrees; the last pools all arm segments."""


def numbers_of(
    entries: Sequence[RunEntry],
    judgements: Mapping[RunEntry, Judgement],
    stretches: Sequence[Segment],
    threshold: float,
) -> tuple[StretchNumbers, ...]:
    """Statistics: the first stretch for every run, the others for the first run alone."""
    shown = [entry for entry in entries if entry in judgements]
    wanted = [(entry, stretches[0]) for entry in shown]
    wanted += [(entry, stretch) for entry in shown[:1] for stretch in stretches[1:]]
    return tuple(
        _numbers(entry, judgements[entry], stretch, threshold) for entry, stretch in wanted
    )


def stretches_of(
    selection: range | None, count: int, segments: Sequence[Segment]
) -> tuple[Segment, ...]:
    """The selection, or the whole recording where nothing is selected, then every segment."""
    if selection:
        return (Segment("selection", selection.start, selection.stop), *segments)
    return (Segment("whole recording", 0, count), *segments)


def columns(threshold: float, measure: str) -> tuple[Column, ...]:
    """Columns of the panel."""
    own = "error" if measure == "error" else "standard deviation"
    lost = (
        "Share of frames in which the limb is more than 45° off, %"
        if measure == "error"
        else "Share of frames with a failure probability above one half, %"
    )
    headings = {
        "mean": f"Mean {own}, degrees",
        "median": f"Median {own}, degrees",
        "95 %": f"95th percentile of the {own}, degrees",
        "max": f"Largest {own}, degrees",
        f"> {threshold:.0f}°": "Share of frames above the threshold of the plot, %",
        "lost": lost,
    }
    return tuple(Column(heading, tip, RIGHT) for heading, tip in headings.items())


def groups(numbers: Sequence[StretchNumbers]) -> tuple[TreeRow, ...]:
    """Rows of the panel; those of runs beside the first are named after them."""
    result = []
    for i, one in enumerate(numbers):
        other = one.run != numbers[0].run
        title = f"{one.run}, {one.stretch.name}" if other else one.stretch.name
        rows = tuple(
            TreeRow((Cell(limb_words(row.limb), swatch=LIMB_COLOURS[row.limb]), *_cells(row)))
            for row in one.limbs
            if row.limb != ALL_ARMS
        )
        pooled = next(_cells(row) for row in one.limbs if row.limb == ALL_ARMS)
        frames = f"frames {one.stretch.first} – {one.stretch.end - 1}"
        hint = f"{one.measure.capitalize()} of {one.run}, {frames}. Beside the name: all arms."
        result.append(TreeRow((Cell(title, hint, bold=True), *pooled), rows, open=i == 0))
    return tuple(result)


def words(numbers: Sequence[StretchNumbers], judgement: Judgement) -> str:
    """What the numbers are of."""
    if not numbers:
        return ""
    first, end = numbers[0].stretch.first, numbers[0].stretch.end
    where = f"{numbers[0].stretch.name}, frames {first} – {end - 1}"
    if judgement.truth is None:
        return (
            f"No reference. Standard deviation of {numbers[0].run} as estimated by the tracker, "
            f"degrees, {where}."
        )
    return f"Angular error of {numbers[0].run} against {judgement.truth.words}, degrees, {where}."


def as_csv(numbers: Sequence[StretchNumbers], threshold: float) -> str:
    """The same as a table for other programs."""

    def cell(value: float) -> str | float:
        return "" if np.isnan(value) else round(value, 4)

    rows: list[list[str | float | int]] = [
        [
            one.run, one.stretch.name, one.stretch.first, one.stretch.end, row.limb, one.measure,
            row.count, *map(cell, (row.mean, row.median, row.p95, row.maximum)), threshold,
            *map(cell, (100.0 * row.above, 100.0 * row.lost)),
        ]
        for one in numbers
        for row in one.limbs
    ]  # fmt: skip
    return csv_text(_CSV, rows)


def _cells(row: LimbStatistics) -> CellRow:
    shares = (100.0 * row.above, 100.0 * row.lost)
    return [
        Cell("–", "unknown", "muted") if np.isnan(value) else Cell(f"{value:.1f}")
        for value in (row.mean, row.median, row.p95, row.maximum, *shares)
    ]


def _numbers(
    entry: RunEntry, judgement: Judgement, stretch: Segment, threshold: float
) -> StretchNumbers:
    inside = (judgement.frame >= stretch.first) & (judgement.frame < stretch.end)
    values = {limb: judgement.limbs[limb][inside] for limb in MEASURED_LIMBS}
    lost = {limb: own[inside] for limb, own in _lost(judgement).items()}
    limbs = limb_statistics(values, lost, threshold)
    return StretchNumbers(entry.name, stretch, judgement.words, limbs)


def _lost(judgement: Judgement) -> dict[str, FloatArray]:
    """Whether each arm segment is lost (1) or not (0): by its error, or as the tracker says."""
    if judgement.measure == "error":
        limbs, limit = judgement.limbs, LOST_DEG
    else:
        limbs, limit = dict(judgement.lost), LOST_SHARE
    return {
        limb: np.where(np.isfinite(values), (values > limit).astype(np.float64), np.nan)
        for limb, values in limbs.items()
        if limb.endswith(("upper_arm", "forearm"))
    }
