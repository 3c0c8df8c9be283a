"""The store of a study: a journal of results, each written at once, and a table made of it."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from stereotrack_core.atomic import forget_unfinished, write_file
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.measures import MEASURES
from stereotrack_core.interop.records import Journal, read_journal
from stereotrack_core.locks import lock_output
from stereotrack_core.study.job import Job, JobResult
from stereotrack_core.study.points import varied_names
from stereotrack_core.tables import csv_text, read_csv_table

JOB_COLUMN = "job"
"""Column of identities, by which a table of ours is known."""


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
    """Writes journal and table; one process at a time.

    Raises InputError if another process writes to it, or the table belongs to something else.
    """

    def __init__(self, table: Path) -> None:
        self.table = table
        _check_table(table)
        self._lock = lock_output(table)
        try:
            forget_unfinished(table)
            self.results = stored_results(table)
            self._journal = Journal(journal_of(table))
        except BaseException:
            self._lock.release()
            raise

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *_: object) -> None:
        self._journal.close()
        self._lock.release()

    def keep(self, job: Job, result: JobResult) -> None:
        """Write a result to the journal."""
        told = {"recording": job.recording, "seed": job.seed, "point": job.point.by_name}
        self._journal.append({**result.facts(), **told})
        self.results[result.identity] = result

    def search_batch(self, search: str, wanted: int) -> int:
        """Points that a search asks for at once: as many as when it was first begun.

        Other numbers would give other points, and the search could not be resumed.
        """
        for entry in read_journal(journal_of(self.table)):
            if entry.get("search") == search and isinstance(entry.get("batch"), int):
                return max(1, int(entry["batch"]))
        self._journal.append({"search": search, "batch": wanted})
        return wanted

    def write_table(self, jobs: Sequence[Job]) -> None:
        """Write the table of all jobs that have a result."""
        columns, rows = table_of(jobs, self.results)
        write_file(self.table, csv_text(columns, rows))


def table_of(
    jobs: Sequence[Job], results: dict[str, JobResult]
) -> tuple[list[str], list[list[str | float | int]]]:
    """Columns and rows of the table: a row for every job that has a result."""
    varied = varied_names(job.point for job in jobs)
    columns = [
        "recording", *varied, "seed", "status", *(measure.name for measure in MEASURES),
        "frames", "attempts", "error", JOB_COLUMN,
    ]  # fmt: skip
    rows: list[list[str | float | int]] = []
    for job in jobs:
        result = results.get(job.identity)
        if result is None:
            continue
        values = job.point.by_name
        rows.append([
            job.recording, *(_cell(values.get(name, "")) for name in varied), job.seed,
            result.status, *(result.measures.get(measure.name, "") for measure in MEASURES),
            result.frames, result.attempts, result.error, job.identity,
        ])  # fmt: skip
    return columns, rows


def _cell(value: str | float | int | bool) -> str | float | int:
    return ("yes" if value else "no") if isinstance(value, bool) else value


def _check_table(table: Path) -> None:
    """Refuse to write over a table that is something else."""
    if not table.exists() or not table.stat().st_size:
        return
    try:
        columns, _ = read_csv_table(table)
    except InputError:
        columns = ()
    if JOB_COLUMN not in columns:
        raise InputError(
            "the file exists and is not a sweep table",
            where=str(table),
            remedy="Choose another table.",
        )
