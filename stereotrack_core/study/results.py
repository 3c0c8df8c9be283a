"""All numbers of a study as one tidy table: one value per row, ready for statistics."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, TypeAlias

from stereotrack_core.atomic import replacing, write_file
from stereotrack_core.errors import InputError
from stereotrack_core.study.file import RESULT_COLUMNS, Study
from stereotrack_core.study.status import RowStatus
from stereotrack_core.tables import csv_text
from stereotrack_core.version import __version__
from stereotrack_core.versions import extra_library

Cell: TypeAlias = str | int | float | None

RESULT_SUFFIXES = (".csv", ".parquet")

_NUMBERS = {"seed": "int64", "value": "float64", "up_to_date": "bool_"}
"""Columns that are no texts, by their type in Parquet."""


def result_columns(study: Study) -> tuple[str, ...]:
    """Columns of the table: what was recorded, factors, the run, the value with its unit."""
    return ("recording", "project", *study.factors, *RESULT_COLUMNS)


def result_rows(study: Study, rows: Sequence[RowStatus]) -> Iterator[tuple[Cell, ...]]:
    """The rows of the table, run by run; runs that cannot be read have none."""
    for row in rows:
        about = [row.row.recording, row.row.project]
        about += [row.row.factors.get(name, "") for name in study.factors]
        for run in row.runs:
            facts, place = run.facts, run.place
            made: list[Cell] = [place.name, place.kept_in, facts.preset, facts.changes, facts.seed]
            made += [facts.reference, not run.outdated]
            for one in facts.values:
                yield (*about, *made, one.measure, one.statistic, one.unit, one.value)


def check_results(path: Path) -> None:
    """Refuse a file that results cannot be written to. Raises InputError that says what can."""
    suffix = path.suffix.lower()
    if suffix not in RESULT_SUFFIXES:
        raise InputError(
            "a table of results cannot be written to this type of file",
            where=str(path),
            remedy=f"Use a name that ends in {' or '.join(RESULT_SUFFIXES)}.",
        )
    if path.name.endswith(".study.csv"):
        raise InputError(
            "this is the name of a study file", where=str(path), remedy="Use another name."
        )
    if suffix == ".parquet":
        _pyarrow()


def write_result_table(path: Path, study: Study, rows: Sequence[RowStatus]) -> int:
    """Write the table (.csv or .parquet); the number of its rows.

    In CSV, texts that a spreadsheet would compute are guarded, and what is not known is empty.
    Raises InputError where it cannot be written.
    """
    check_results(path)
    columns, table = result_columns(study), list(result_rows(study, rows))
    if path.suffix.lower() == ".csv":
        write_file(path, csv_text(columns, ([_csv(cell) for cell in row] for row in table)))
    else:
        _write_parquet(path, columns, table)
    return len(table)


def _csv(cell: Cell) -> str | int | float:
    if isinstance(cell, bool):
        return "yes" if cell else "no"
    return "" if cell is None else cell


def _pyarrow() -> Any:
    return extra_library(
        "pyarrow",
        "parquet",
        missing="PyArrow is not installed, which is needed for Parquet files",
        where="-o",
        instead="a .csv file",
    )


def _write_parquet(path: Path, columns: Sequence[str], rows: Sequence[Sequence[Cell]]) -> None:
    arrow = _pyarrow()
    from pyarrow import parquet

    kinds = [getattr(arrow, _NUMBERS.get(name, "string"))() for name in columns]
    arrays = [arrow.array([row[i] for row in rows], type=kind) for i, kind in enumerate(kinds)]
    units = {"program": "stereotrack", "version": __version__, "unit_of_value": "column unit"}
    schema = arrow.schema(
        list(zip(columns, kinds, strict=True)), metadata={"stereotrack": json.dumps(units)}
    )
    table = arrow.Table.from_arrays(arrays, schema=schema)
    with replacing(path, lambda written: bool(parquet.read_table(written).equals(table))) as file:
        parquet.write_table(table, file)
