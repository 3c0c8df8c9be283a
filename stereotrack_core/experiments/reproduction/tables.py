"""The thesis's four tables with our numbers below its own, and two more."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from stereotrack_core.evaluation.errors import LimbErrors
from stereotrack_core.experiments.reproduction.outcomes import (
    FAST,
    LOST,
    Figure,
    Outcome,
    Part,
    figure,
)
from stereotrack_core.experiments.reproduction.plan import (
    LEFT_OUT_WITH_FEW_VIEWS,
    POINTS,
    THESIS,
    Way,
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

OF_THESIS = "the thesis"
_LOST_ROW = (LOST, "arm segments lost", "%")


@dataclass(frozen=True)
class Line:
    """One line of a table.

    Attributes
    ----------
    measure, label, unit : str
    source : str
        Whose numbers: the thesis's, or those of a way of tracking.
    figures : tuple of Figure
        One for each column.
    """

    measure: str
    label: str
    unit: str
    source: str
    figures: tuple[Figure, ...]


@dataclass(frozen=True)
class ComparedTable:
    """A table in which numbers of several sources stand below each other.

    Attributes
    ----------
    key : str
        Name of its files.
    title : str
    columns : tuple of str
    lines : tuple of Line
    remark : str
    """

    key: str
    title: str
    columns: tuple[str, ...]
    lines: tuple[Line, ...]
    remark: str


@dataclass(frozen=True)
class _Column:
    """What a column takes from which outcomes."""

    way: Way
    recordings: tuple[str, ...]
    part: Part = Outcome.slow


def compared_tables(
    outcomes: Sequence[Outcome], recordings: Sequence[str], presets: Sequence[str]
) -> tuple[ComparedTable, ...]:
    """Tables 4.1 to 4.4, the same as 4.1 for fast motions, and the motions of section 4.3."""
    return (
        _table_4_1(outcomes, recordings, presets),
        _table_4_2(outcomes, recordings, presets),
        _table_4_3(outcomes, recordings, presets),
        _table_4_4(outcomes, recordings, presets),
        _fast_table(outcomes, recordings, presets),
        _motion_table(outcomes, recordings, presets),
    )


def source_name(way: Way) -> str:
    """How the lines of a way of tracking are called."""
    if way.preset != THESIS:
        return way.preset
    return "preset thesis, re-initialised" if way.anew else "preset thesis"


def _basic_ways(presets: Sequence[str]) -> list[Way]:
    ways: list[Way] = []
    for name in presets:
        ways += [Way(name), Way(name, anew=True)] if name == THESIS else [Way(name)]
    return ways


def _table_4_1(
    outcomes: Sequence[Outcome], recordings: Sequence[str], presets: Sequence[str]
) -> ComparedTable:
    each = [*((name,) for name in TABLE_4_1.columns[:-1]), tuple(recordings)]
    columns = {way: [_Column(way, names) for names in each] for way in _basic_ways(presets)}
    return _beside(TABLE_4_1, columns, outcomes)


def _table_4_2(
    outcomes: Sequence[Outcome], recordings: Sequence[str], presets: Sequence[str]
) -> ComparedTable:
    columns: dict[Way, list[_Column]] = {}
    if THESIS in presets:
        reference = Way(THESIS)
        usual = reference.settings.tracking.model_points
        ways = [reference if m == usual else Way(THESIS, points=m) for m in POINTS]
        columns[reference] = [_Column(way, tuple(recordings)) for way in ways]
    return _beside(TABLE_4_2, columns, outcomes)


def _table_4_3(
    outcomes: Sequence[Outcome], recordings: Sequence[str], presets: Sequence[str]
) -> ComparedTable:
    kept = tuple(name for name in recordings if name != LEFT_OUT_WITH_FEW_VIEWS)
    columns = {
        Way(name): [_Column(Way(name, few_views=True), kept), _Column(Way(name), kept)]
        for name in presets
    }
    return _beside(TABLE_4_3, columns, outcomes)


def _table_4_4(
    outcomes: Sequence[Outcome], recordings: Sequence[str], presets: Sequence[str]
) -> ComparedTable:
    everybody = tuple(recordings)
    columns = {
        Way(name): [_Column(Way(name, averaged=True), everybody), _Column(Way(name), everybody)]
        for name in presets
    }
    return _beside(TABLE_4_4, columns, outcomes)


def _fast_table(
    outcomes: Sequence[Outcome], recordings: Sequence[str], presets: Sequence[str]
) -> ComparedTable:
    each = [*((name,) for name in recordings), tuple(recordings)]
    lines = [
        line
        for measure in (*ROWS, _LOST_ROW)
        for way in _basic_ways(presets)
        for line in _line(
            measure, way, [_Column(way, names, Outcome.fast) for names in each], outcomes
        )
    ]
    return ComparedTable(
        "fast",
        "The four motions performed fast",
        (*recordings, "together"),
        tuple(lines),
        "The thesis has no such numbers: the same motions in about 3 seconds each. Fast motion "
        "can lose an arm, and a tracker without re-initialisation does not find it again.",
    )


def _motion_table(
    outcomes: Sequence[Outcome], recordings: Sequence[str], presets: Sequence[str]
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
        for way in _basic_ways(presets):
            part = partial(_segment_of, segment)
            figures = tuple(
                figure(outcomes, way.name, name, part, having) for name, _, _ in measures
            )
            if any(math.isfinite(f.mean) for f in figures):
                label = segment.removesuffix(FAST) + (", fast" if segment.endswith(FAST) else "")
                lines.append(Line(segment, label, "", source_name(way), figures))
    return ComparedTable(
        "motions",
        "The motions of section 4.3, at the thesis's pace and fast",
        tuple(f"{label} [{unit}]" for _, label, unit in measures),
        tuple(lines),
        "Pooled over all recordings that contain the motion.",
    )


def _segment_of(name: str, outcome: Outcome) -> LimbErrors | None:
    return outcome.segment(name)


def _beside(
    thesis: ThesisTable, columns: dict[Way, list[_Column]], outcomes: Sequence[Outcome]
) -> ComparedTable:
    lines: list[Line] = []
    for measure in (*ROWS, _LOST_ROW):
        name, label, unit = measure
        if name in thesis.values:
            theirs = tuple(Figure(float(value)) for value in thesis.values[name])
            lines.append(Line(name, label, unit, OF_THESIS, theirs))
        for way, own in columns.items():
            lines += _line(measure, way, own, outcomes)
    return ComparedTable(
        thesis.number,
        f"Table {thesis.number}: {thesis.title[0].lower()}{thesis.title[1:]}",
        thesis.columns,
        tuple(lines),
        f"{thesis.remark} (The thesis, {thesis.source}.)",
    )


def _line(
    measure: tuple[str, str, str],
    way: Way,
    columns: Sequence[_Column],
    outcomes: Sequence[Outcome],
) -> list[Line]:
    """A line, or none where nothing of it is known yet."""
    name, label, unit = measure
    figures = tuple(
        figure(outcomes, column.way.name, name, column.part, column.recordings)
        for column in columns
    )
    if not any(math.isfinite(f.mean) for f in figures):
        return []
    return [Line(name, label, unit, source_name(way), figures)]
