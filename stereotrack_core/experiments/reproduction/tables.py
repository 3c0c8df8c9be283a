"""The thesis's four tables with our numbers below its own, and two more."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial, reduce

from stereotrack_core.evaluation.errors import LimbErrors, errors_against
from stereotrack_core.evaluation.summary import Spread, Summary, summarise
from stereotrack_core.experiments.reproduction.plan import (
    LEFT_OUT_WITH_FEW_VIEWS,
    POINTS,
    THESIS,
    PlannedRun,
)
from stereotrack_core.experiments.reproduction.thesis import (
    MOTIONS,
    ROWS,
    TABLE_4_1,
    TABLE_4_2,
    TABLE_4_3,
    TABLE_4_4,
    ThesisTable,
)
from stereotrack_core.recording.description import Recording, Segment
from stereotrack_core.tables import Table
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.presets import preset

FAST = "-fast"
"""End of the names of segments that are faster than the thesis's people were."""

LOST = "lost"


@dataclass(frozen=True, eq=False)
class Outcome:
    """What one run has come to."""

    recording: str
    planned: PlannedRun
    errors: LimbErrors
    fast_from: int
    """First frame of the fast motions at the end of the recording."""
    segments: tuple[Segment, ...]
    version: str
    """Of the program that tracked."""

    def slow(self) -> LimbErrors:
        """Errors of the frames at the thesis's pace."""
        return self.errors.between(0, self.fast_from)

    def fast(self) -> LimbErrors:
        """Errors of the frames from the first fast motion on."""
        return self.errors.between(self.fast_from, int(self.errors.frame[-1]) + 1)

    def segment(self, name: str) -> LimbErrors | None:
        """Errors of all segments of that name; None where there is none."""
        found = [self.errors.between(s.first, s.end) for s in self.segments if s.name == name]
        return reduce(LimbErrors.followed_by, found) if found else None


Part = Callable[[Outcome], LimbErrors | None]
"""Takes the frames that count out of an outcome; None where it has none."""


def outcome_of(recording: Recording, planned: PlannedRun, run: Run) -> Outcome:
    """Measure a run against its recording's reference, which must be there."""
    reference = recording.reference
    if reference is None:
        raise ValueError("the recording has no reference")
    return Outcome(
        recording.name,
        planned,
        errors_against(run.trajectory(), reference),
        fast_from(recording.segments, int(reference.frame[-1]) + 1),
        recording.segments,
        str(run.meta.get("version", "")),
    )


def fast_from(segments: Sequence[Segment], end: int) -> int:
    """First frame of the first fast segment; `end` where there is none."""
    return min((s.first for s in segments if s.name.endswith(FAST)), default=end)


def figure(
    outcomes: Sequence[Outcome], way: str, measure: str, part: Part, recordings: Sequence[str]
) -> Spread:
    """One number of a table: pooled over all frames of the recordings, then over seeds.

    Nothing is said (NaN) until all recordings that are asked for have a run of every seed that
    one of them has.
    """
    own = [o for o in outcomes if o.planned.way == way and o.recording in recordings]
    seeds = sorted({outcome.planned.seed for outcome in own})
    values = []
    for seed in seeds:
        of_seed = [outcome for outcome in own if outcome.planned.seed == seed]
        if {outcome.recording for outcome in of_seed} != set(recordings):
            return Spread()
        stretches = [stretch for o in of_seed if (stretch := part(o)) is not None]
        if stretches:
            values.append(_value(summarise(reduce(LimbErrors.followed_by, stretches)), measure))
    return Spread.of(values)


def _value(summary: Summary, measure: str) -> float:
    if measure == LOST:
        return 100.0 * summary.lost
    return summary.measure(measure).statistics.mean


OF_THESIS = "the thesis"
_LOST_ROW = (LOST, "arm segments lost", "%")


@dataclass(frozen=True)
class Line:
    """One line of a table."""

    measure: str
    label: str
    unit: str
    source: str
    """Whose numbers: the thesis's, or those of a way of tracking."""
    figures: tuple[Spread, ...]
    """One for each column."""


@dataclass(frozen=True)
class ComparedTable:
    """A table in which numbers of several sources stand below each other."""

    key: str
    """Name of its files."""
    title: str
    columns: tuple[str, ...]
    lines: tuple[Line, ...]
    remark: str


@dataclass(frozen=True)
class _Column:
    """What a column takes from which outcomes."""

    planned: PlannedRun
    recordings: tuple[str, ...]
    part: Part = Outcome.slow


def compared_tables(
    outcomes: Sequence[Outcome], recordings: Sequence[str], presets: Sequence[str]
) -> tuple[ComparedTable, ...]:
    """Tables 4.1 to 4.4, the same as 4.1 for fast motions, and the motions of section 4.3."""
    everybody = tuple(recordings)
    each = [*((name,) for name in TABLE_4_1.columns[:-1]), everybody]
    few = tuple(name for name in recordings if name != LEFT_OUT_WITH_FEW_VIEWS)
    usual = preset(THESIS).tracking.model_points
    sizes = [PlannedRun(THESIS, points=None if m == usual else m) for m in POINTS]
    plain = [PlannedRun(name) for name in presets]
    basic = [run for one in plain for run in (one, replace(one, anew=True))]
    # only runs of the thesis's preset are begun anew
    basic = [run for run in basic if not run.anew or run.preset == THESIS]
    columns: dict[ThesisTable, dict[PlannedRun, list[_Column]]] = {
        TABLE_4_1: {run: [_Column(run, names) for names in each] for run in basic},
        TABLE_4_2: {run: [_Column(one, everybody) for one in sizes]
                    for run in plain if run.preset == THESIS},
        TABLE_4_3: {run: [_Column(replace(run, few_views=True), few), _Column(run, few)]
                    for run in plain},
        TABLE_4_4: {run: [_Column(replace(run, averaged=True), everybody), _Column(run, everybody)]
                    for run in plain},
    }  # fmt: skip
    return (
        *(_beside(table, own, outcomes) for table, own in columns.items()),
        _fast_table(outcomes, recordings, basic),
        _motion_table(outcomes, recordings, basic),
    )


def source_name(run: PlannedRun) -> str:
    """How the lines of a way of tracking are called."""
    if run.preset != THESIS:
        return run.preset
    return "preset thesis, re-initialised" if run.anew else "preset thesis"


def _fast_table(
    outcomes: Sequence[Outcome], recordings: Sequence[str], basic: Sequence[PlannedRun]
) -> ComparedTable:
    each = [*((name,) for name in recordings), tuple(recordings)]
    columns = {run: [_Column(run, names, Outcome.fast) for names in each] for run in basic}
    return ComparedTable(
        "fast",
        "The four motions performed fast",
        (*recordings, "together"),
        _lines(columns, outcomes, {}),
        "The thesis has no such numbers: the same motions in about 3 seconds each. Fast motion "
        "can lose an arm, and a tracker without re-initialisation does not find it again.",
    )


def _motion_table(
    outcomes: Sequence[Outcome], recordings: Sequence[str], basic: Sequence[PlannedRun]
) -> ComparedTable:
    names = list(dict.fromkeys(motion.segment for motion in MOTIONS))
    measures = (*ROWS[3:], _LOST_ROW)
    lines = []
    for segment in [*names, *(name + FAST for name in names)]:
        having = tuple(
            name
            for name in recordings
            if any(o.recording == name and o.segment(segment) is not None for o in outcomes)
        )
        if not having:
            continue
        for run in basic:
            part = partial(Outcome.segment, name=segment)
            figures = tuple(
                figure(outcomes, run.way, name, part, having) for name, _, _ in measures
            )
            if any(math.isfinite(f.mean) for f in figures):
                label = segment.removesuffix(FAST) + (", fast" if segment.endswith(FAST) else "")
                lines.append(Line(segment, label, "", source_name(run), figures))
    return ComparedTable(
        "motions",
        "The motions of section 4.3, at the thesis's pace and fast",
        tuple(f"{label} [{unit}]" for _, label, unit in measures),
        tuple(lines),
        "Pooled over all recordings that contain the motion.",
    )


def _beside(
    thesis: ThesisTable, columns: dict[PlannedRun, list[_Column]], outcomes: Sequence[Outcome]
) -> ComparedTable:
    return ComparedTable(
        thesis.number,
        f"Table {thesis.number}: {thesis.title[0].lower()}{thesis.title[1:]}",
        thesis.columns,
        _lines(columns, outcomes, thesis.values),
        f"{thesis.remark} (The thesis, {thesis.source}.)",
    )


def _lines(
    columns: Mapping[PlannedRun, Sequence[_Column]],
    outcomes: Sequence[Outcome],
    given: Mapping[str, Sequence[float]],
) -> tuple[Line, ...]:
    """What is given and what ways of tracking come to, as far as it is known, by measure."""
    lines = []
    for name, label, unit in (*ROWS, _LOST_ROW):
        sources = [(OF_THESIS, tuple(Spread(float(value)) for value in given.get(name, ())))]
        for run, own in columns.items():
            figures = (figure(outcomes, c.planned.way, name, c.part, c.recordings) for c in own)
            sources.append((source_name(run), tuple(figures)))
        for source, found in sources:
            if any(math.isfinite(one.mean) for one in found):
                lines.append(Line(name, label, unit, source, found))
    return tuple(lines)


def _rows_of(compared: ComparedTable) -> list[tuple[str, ...]]:
    """Rows for reading; a measure is named once."""
    rows: list[tuple[str, ...]] = []
    before = ""
    for line in compared.lines:
        label = "" if line.label == before else _named(line)
        before = line.label
        rows.append(
            (
                label,
                line.source,
                *(f.text(0 if line.unit == "mm" else 1) for f in line.figures),
            )
        )
    return rows


def readable(compared: ComparedTable) -> Table:
    """The table for reading, the thesis's own numbers set apart."""
    rows = _rows_of(compared)
    kinds = [
        " ".join(["first"] * bool(cells[0]) + ["given"] * (line.source == OF_THESIS))
        for cells, line in zip(rows, compared.lines, strict=True)
    ]
    columns = ("", "", *(f">{name}" for name in compared.columns))
    return Table(compared.title, columns, rows, kinds)


def in_full(compared: ComparedTable) -> tuple[list[str], list[list[str | float | int]]]:
    """Columns and rows with every number in full, for CSV."""
    columns = ["measure", "unit", "source"]
    for name in compared.columns:
        columns += [name, f"{name} (standard deviation over seeds)"]
    rows: list[list[str | float | int]] = []
    for line in compared.lines:
        row: list[str | float | int] = [line.label, line.unit, line.source]
        for figure in line.figures:
            row += [_known(figure.mean), _known(figure.deviation)]
        rows.append(row)
    return columns, rows


def facts(tables: Sequence[ComparedTable]) -> list[dict[str, object]]:
    """The tables for JSON."""
    return [
        {
            "table": compared.key,
            "title": compared.title,
            "columns": list(compared.columns),
            "rows": [
                {
                    "measure": line.measure,
                    "label": line.label,
                    "unit": line.unit,
                    "source": line.source,
                    "mean": [figure.mean for figure in line.figures],
                    "standard_deviation": [figure.deviation for figure in line.figures],
                }
                for line in compared.lines
            ],
        }
        for compared in tables
    ]


def _named(line: Line) -> str:
    return f"{line.label} [{line.unit}]" if line.unit else line.label


def _known(value: float) -> str | float:
    return value if math.isfinite(value) else ""
