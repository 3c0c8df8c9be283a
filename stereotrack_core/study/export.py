"""All values of a study as one tidy table: one value per row, ready for statistics."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TypeAlias

from stereotrack_core.atomic import write_file
from stereotrack_core.parameters import value_text
from stereotrack_core.study.description import RESULT_COLUMNS, Study
from stereotrack_core.study.job import Job, JobResult
from stereotrack_core.study.values import named
from stereotrack_core.tables import csv_text

Cell: TypeAlias = str | int | float


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


def write_result_table(
    path: Path, study: Study, jobs: Sequence[Job], results: Mapping[str, JobResult]
) -> int:
    """Write the table (.csv); the number of its rows. Raises InputError if it cannot be written."""
    columns = ("recording", "project", *study.factors, *RESULT_COLUMNS)
    table = list(result_rows(study, jobs, results))
    write_file(path, csv_text(columns, table))
    return len(table)
