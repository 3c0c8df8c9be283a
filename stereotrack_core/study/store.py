"""The store of a study: a journal of results, tables made of it, and how they are looked at."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.atomic import forget_unfinished, write_file
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.measures import MEASURES, measure_named
from stereotrack_core.evaluation.summary import Spread
from stereotrack_core.interop.records import append_entry, read_journal
from stereotrack_core.locks import lock_output
from stereotrack_core.parameters import value_text
from stereotrack_core.study.description import RESULT_COLUMNS, Study, cell_of
from stereotrack_core.study.job import Job, JobResult, named
from stereotrack_core.study.points import parameter_rows, varied_names
from stereotrack_core.tables import csv_text, read_csv_table

JOB_COLUMN = "job"  # column of identities, by which a table of ours is known


def journal_of(table: Path) -> Path:
    """The journal beside a table."""
    return table.with_suffix(".jobs.jsonl")


def stored_results(table: Path) -> dict[str, JobResult]:
    """Every result of the journal by its job; the newest if there are several."""
    results = {}
    for entry in read_journal(journal_of(table)):
        with suppress(InputError):  # for other entries of the journal
            result = JobResult.of_facts(entry)
            results[result.identity] = result
    return results


class Store:
    """Writes journal and table; one process at a time. Raises InputError for another's."""

    def __init__(self, table: Path) -> None:
        self.table = table
        _check_table(table)
        self._lock = lock_output(table)
        try:
            forget_unfinished(table)
            self.results = stored_results(table)
        except BaseException:
            self._lock.release()
            raise

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *_: object) -> None:
        self._lock.release()

    def keep(self, job: Job, result: JobResult) -> None:
        """Write a result to the journal."""
        told = {"recording": job.recording, "seed": job.spec.seed, "point": job.point.by_name}
        append_entry(journal_of(self.table), {**result.facts(), **told})
        self.results[result.identity] = result

    def write_table(self, jobs: Sequence[Job]) -> None:
        """Write the table of all jobs that have a result."""
        columns, rows = table_of(jobs, self.results)
        write_file(self.table, csv_text(columns, rows))


def table_of(
    jobs: Sequence[Job], results: dict[str, JobResult]
) -> tuple[list[str], list[list[str | float | int]]]:
    """Columns and rows of the table: a row for every job that has a result."""
    varied = varied_names(job.point for job in jobs)
    done = (results[job.identity].measures for job in jobs if job.identity in results)
    measures = [*(measure.name for measure in MEASURES), *segment_measures(done)]
    columns = [
        "recording", *varied, "seed", "status", *measures,
        "frames", "attempts", "error", JOB_COLUMN,
    ]  # fmt: skip
    rows: list[list[str | float | int]] = []
    for job in jobs:
        result = results.get(job.identity)
        if result is None:
            continue
        values = job.point.by_name
        rows.append([
            job.recording, *(cell_of(values.get(name, "")) for name in varied), job.spec.seed,
            result.status, *(result.measures.get(name, "") for name in measures),
            result.frames, result.attempts, result.error, job.identity,
        ])  # fmt: skip
    return columns, rows


def segment_measures(results: Iterable[Mapping[str, float]]) -> list[str]:
    """Measures of named stretches, such as ``crossing/forearms``, that some results have."""
    return list(dict.fromkeys(name for one in results for name in one if "/" in name))


def _check_table(table: Path) -> None:
    if not table.exists() or not table.stat().st_size:
        return
    try:
        columns, _ = read_csv_table(table)
    except InputError:
        columns = ()
    if JOB_COLUMN not in columns:
        raise InputError("the file exists and is not a sweep table", table, "Choose another table.")


def _result_rows(
    study: Study, jobs: Sequence[Job], results: Mapping[str, JobResult]
) -> Iterator[tuple[str | int | float, ...]]:
    by_name = {row.recording: row for row in study.rows}
    for job in jobs:
        result = results.get(job.identity)
        if result is None or not result.done:
            continue
        row, name = by_name[job.recording], Path(job.keep).stem
        about = [job.recording, row.project, *(row.cell(factor) for factor in study.factors)]
        varied = (f"{key}={value_text(value)}" for key, value in job.point.without_seed.values)
        changes = " ".join((*study.settings.changes, *varied))
        for key, value in {"frames:count": float(result.frames), **result.measures}.items():
            yield (*about, name, job.spec.preset, changes, job.spec.seed, *named(key), value)


def write_result_table(
    path: Path, study: Study, jobs: Sequence[Job], results: Mapping[str, JobResult]
) -> int:
    """Write the table (.csv); the number of its rows. Raises InputError if it cannot be written."""
    columns = ("recording", "project", *study.factors, *RESULT_COLUMNS)
    table = list(_result_rows(study, jobs, results))
    write_file(path, csv_text(columns, table))
    return len(table)


_FIXED = ("status", "frames", "attempts", "error", "job")
_LOG_FROM = 20.0  # largest over smallest value from which an axis is logarithmic
AVERAGED = ("recording", "seed")  # columns that are averaged over unless somebody asks for them


@dataclass(frozen=True)
class RunTable:
    """Rows of runs that were done; every cell is text."""

    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    failed: int = 0  # runs that were left out because they failed

    @property
    def varied(self) -> tuple[str, ...]:
        """Columns that are no measures and have more than one value."""
        return tuple(name for name in self._told if len(self.values(name)) > 1)

    @property
    def settled(self) -> dict[str, str]:
        """Columns that are no measures and have the same value throughout."""
        return {name: self.values(name)[0] for name in self._told if len(self.values(name)) == 1}

    @property
    def _told(self) -> list[str]:
        return [n for n in self.columns if n not in _FIXED and measure_named(n) is None]

    @property
    def measures(self) -> tuple[str, ...]:
        """Measures that are known for some run."""
        usual = [measure.name for measure in MEASURES if measure.name in self.columns]
        others = [name for name in self.columns if "/" in name and measure_named(name) is not None]
        return tuple(n for n in (*usual, *others) if np.isfinite(self.numbers(n)).any())

    def cells(self, name: str) -> list[str]:
        """A column, row by row."""
        place = self.columns.index(name)
        return [row[place] for row in self.rows]

    def values(self, name: str) -> tuple[str, ...]:
        """Different values of a column: numbers by size, words as they come."""
        found = tuple(dict.fromkeys(self.cells(name)))
        return tuple(sorted(found, key=float)) if all(map(is_number, found)) else found

    def numbers(self, name: str) -> FloatArray:
        """A column (R,) as numbers; NaN for a cell that is none."""
        return np.array([float(c) if is_number(c) else np.nan for c in self.cells(name)])

    def common(self, rows: Iterable[int]) -> dict[str, str]:
        """The varied values that some rows have in common."""
        own = list(rows)
        cells = {name: {self.cells(name)[i] for i in own} for name in self.varied}
        return {name: found.pop() for name, found in cells.items() if len(found) == 1}

    def best(self, measure: str) -> tuple[int, ...]:
        """Rows of the point with the best mean of a measure; empty if nothing is known."""
        columns = [self.columns.index(name) for name in self.varied if name not in AVERAGED]
        known, values = measure_named(measure), self.numbers(measure)
        sign = -1.0 if known is not None and known.more_is_better else 1.0
        points: dict[tuple[str, ...], list[int]] = {}
        for row in np.flatnonzero(np.isfinite(values)).tolist():
            points.setdefault(tuple(self.rows[row][i] for i in columns), []).append(row)
        best = min(points.values(), key=lambda rows: sign * float(values[rows].mean()), default=[])
        return tuple(best)


@dataclass(frozen=True, eq=False)
class PlotAxis:
    """Where values stand: numbers where they are, words side by side."""

    name: str
    places: dict[str, float]
    log: bool
    words: bool  # whether values are names, to be written at their places


@dataclass(frozen=True, eq=False)
class Curve:
    """Runs that agree in one name, over another one."""

    label: str  # ``views NS``; empty if there is one curve only
    x: FloatArray
    y: FloatArray
    row: IntArray  # `x`, `y` and `row`: (N,), a point per run with its row of the table
    at: FloatArray
    mean: FloatArray
    spread: FloatArray  # `at`, `mean`, `spread`: (M,); NaN deviation of a single run


def read_table(path: Path) -> RunTable:
    """Read a table of ``sweep`` or ``study run`` with finished runs. Raises InputError."""
    columns, rows = read_csv_table(path)
    if "job" not in columns or "status" not in columns:
        remedy = "Choose a table written by `stereotrack sweep` or `stereotrack study run`."
        raise InputError("this is not a sweep table", path, remedy)
    place = columns.index("status")
    done = tuple(row for row in rows if row[place] == "done")
    if not done:
        raise InputError("no run of this table is finished yet", path, "Let it continue first.")
    return RunTable(columns, done, failed=len(rows) - len(done))


def axis_of(table: RunTable, name: str) -> PlotAxis:
    """Where the values of a column stand."""
    values = table.values(name)
    if all(map(is_number, values)):
        numbers = [float(value) for value in values]
        log = min(numbers) > 0 and max(numbers) >= _LOG_FROM * min(numbers)
        return PlotAxis(name, dict(zip(values, numbers, strict=True)), log, words=False)
    return PlotAxis(name, {value: float(i) for i, value in enumerate(values)}, False, words=True)


def curves_of(table: RunTable, x: str, y: str, colour: str = "") -> tuple[Curve, ...]:
    """A measure over a column, one curve for each value of a third column, if one is given."""
    places = axis_of(table, x).places
    at = np.array([places[cell] for cell in table.cells(x)])
    height = table.numbers(y)
    labels = table.cells(colour) if colour else [""] * len(table.rows)
    curves = []
    for label in table.values(colour) if colour else ("",):
        own = np.array([one == label for one in labels]) & np.isfinite(height)
        if own.any():
            words = f"{colour.replace('_', ' ')} {label or '(unchanged)'}" if colour else ""
            middles = np.unique(at[own])
            found = [Spread.of(height[own & (at == place)]) for place in middles]
            mean = np.array([one.mean for one in found])
            spread = np.array([one.deviation for one in found])
            curves.append(
                Curve(words, at[own], height[own], np.flatnonzero(own), middles, mean, spread)
            )
    return tuple(curves)


def is_number(text: str) -> bool:
    """Whether a cell is a finite number."""
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def words_of(name: str) -> str:
    """How a column is called on an axis."""
    measure, row = measure_named(name), parameter_rows().get(name)
    if measure is not None:
        return measure.title
    unit = f" [{row.unit}]" if row is not None and row.unit else ""
    return f"{name.replace('_', ' ')}{unit}"


_MOST_GROUPS = 6  # of numbers with more values, neighbours are put together
_LEAST_SHARE = 0.01


@dataclass(frozen=True)
class Effect:
    """Main effect of a parameter on a measure."""

    name: str
    share: float  # of the measure's variance, 0 to 1; NaN if every run has a value of its own
    low: float
    high: float  # `low` and `high`: least and greatest mean of the runs with the same value


def effects_of(table: RunTable, measure: str) -> tuple[Effect, ...]:
    """The :func:`effects` of what a table varies, with recordings taken for equally hard."""
    values, recordings = table.numbers(measure), np.array(table.cells("recording"))
    mean = np.nanmean(values) if np.isfinite(values).any() else 0.0
    for recording in np.unique(recordings[np.isfinite(values)]):
        own = recordings == recording
        values[own] += mean - np.nanmean(values[own])
    names = [name for name in table.varied if name not in AVERAGED]
    return effects({name: table.cells(name) for name in names}, values)


def effects(factors: Mapping[str, Sequence[str]], values: FloatArray) -> tuple[Effect, ...]:
    """Effects of factors, each with its value in R runs, on a measure (R,), the largest first.

    That of one factor is the share of the measure's variance that its values explain, corrected for
    what as many values would explain by chance (omega squared, Hays 1963). What is left belongs to
    seeds and to factors acting together. PED-ANOVA, of the best tenth, needs hundreds of runs.
    """
    known = np.isfinite(values)
    found = []
    for name, cells in factors.items():
        own = [cell for cell, there in zip(cells, known, strict=True) if there]
        if len(set(own)) > 1:
            found.append(_effect(name, _groups(own), values[known]))
    return tuple(sorted(found, key=lambda one: -np.nan_to_num(one.share, nan=-1.0)))


def _groups(cells: Sequence[str]) -> IntArray:
    """Group (R,) of each run: its value, or of many numbers one of equally large parts."""
    values, groups = np.unique(np.array(cells), return_inverse=True)
    if len(values) > _MOST_GROUPS and all(map(is_number, cells)):
        numbers = np.array(cells, dtype=np.float64)
        edges = np.quantile(numbers, np.linspace(0.0, 1.0, _MOST_GROUPS + 1)[1:-1])
        groups = np.digitize(numbers, np.unique(edges))
    return np.asarray(groups, dtype=np.int64)


def _effect(name: str, groups: IntArray, values: FloatArray) -> Effect:
    counts = np.bincount(groups)
    means = np.bincount(groups, values)[counts > 0] / counts[counts > 0]
    count, m = len(values), len(means)
    total = float(np.square(values - values.mean()).sum())
    between = float((counts[counts > 0] * np.square(means - values.mean())).sum())
    share = float("nan")
    if count > m and total > 0.0:
        within = (total - between) / (count - m)
        share = max(0.0, (between - (m - 1) * within) / (total + within))
    return Effect(name, share, float(means.min()), float(means.max()))


def effects_words(effects: Sequence[Effect], unit: str) -> str:
    """``arms apart 41 % (8.1 to 9.9 deg), iterations none``; empty if nothing can be said."""
    told = [
        f"{one.name.replace('_', ' ')} none"
        if one.share < _LEAST_SHARE
        else f"{one.name.replace('_', ' ')} {100.0 * one.share:.0f} % "
        f"({one.low:.1f} to {one.high:.1f} {unit})".replace(" )", ")")
        for one in effects
        if np.isfinite(one.share)
    ]
    together = sum(one.share for one in effects if np.isfinite(one.share)) > 1.0
    return ", ".join(told) + ("; some were changed together, and share it" if together else "")
