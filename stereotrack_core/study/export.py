"""All values of a study as one tidy table: one value per row, ready for statistics."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

from stereotrack_core.atomic import replacing, write_file
from stereotrack_core.errors import InputError
from stereotrack_core.parameters import value_text
from stereotrack_core.study.description import RESULT_COLUMNS, Study
from stereotrack_core.study.job import Job, JobResult
from stereotrack_core.study.values import named
from stereotrack_core.tables import csv_text
from stereotrack_core.version import __version__
from stereotrack_core.versions import extra_library

Cell: TypeAlias = str | int | float

RESULT_SUFFIXES = (".csv", ".parquet")

_NUMBERS = {"seed": "int64", "value": "float64"}
"""Columns that are no texts, by their type in Parquet."""


def result_rows(
    study: Study, jobs: Sequence[Job], results: Mapping[str, JobResult]
) -> Iterator[tuple[Cell, ...]]:
    """A row for each value of each run that is done."""
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
            yield (*about, name, job.spec.preset, changes, job.seed, *named(key), value)


def check_results(path: Path) -> None:
    """Refuse a file that results cannot be written to. Raises InputError."""
    suffix = path.suffix.lower()
    if suffix not in RESULT_SUFFIXES:
        raise InputError(
            "a table of results cannot be written to this type of file",
            where=str(path),
            remedy=f"Use a name that ends in {' or '.join(RESULT_SUFFIXES)}.",
        )
    if suffix == ".parquet":
        _pyarrow()


def write_result_table(
    path: Path, study: Study, jobs: Sequence[Job], results: Mapping[str, JobResult]
) -> int:
    """Write the table (.csv or .parquet); the number of its rows.

    Raises InputError if it cannot be written.
    """
    check_results(path)
    columns = ("recording", "project", *study.factors, *RESULT_COLUMNS)
    table = list(result_rows(study, jobs, results))
    if path.suffix.lower() == ".csv":
        write_file(path, csv_text(columns, table))
    else:
        _write_parquet(path, columns, table)
    return len(table)


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
