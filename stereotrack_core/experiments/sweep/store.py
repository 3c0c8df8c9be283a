"""The files of a sweep: its table, the journal of its results, and how it is going."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeAlias

from stereotrack_core.atomic import forget_unfinished, write_file
from stereotrack_core.errors import InputError
from stereotrack_core.experiments.measures import MEASURES
from stereotrack_core.experiments.runner.job import Job, JobResult
from stereotrack_core.experiments.sweep.points import varied_names
from stereotrack_core.interop.records import Journal, read_journal
from stereotrack_core.locks import is_held, lock_output
from stereotrack_core.plain_data import Kind, check_kind
from stereotrack_core.reading import read_json
from stereotrack_core.tables import csv_text, read_csv_table

JOB_COLUMN = "job"
"""Column of identities: what tells a sweep's table from others."""

Ending: TypeAlias = Literal["", "done", "stopped", "failed"]


@dataclass(frozen=True)
class SweepPlaces:
    """Where the files of a sweep are."""

    table: Path

    @property
    def journal(self) -> Path:
        """Every result, as it came."""
        return self.table.with_suffix(".jobs.jsonl")

    @property
    def state(self) -> Path:
        """How it is going."""
        return self.table.with_name(f".{self.table.name}.state.json")

    @property
    def stop_sign(self) -> Path:
        """Made by whoever wants the sweep to stop."""
        return self.table.with_name(f".{self.table.name}.stop")


@dataclass(frozen=True)
class SweepState:
    """How a sweep is going, or how it ended."""

    jobs: int = 0
    """In all; in a search so far."""
    reused: int = 0
    """That were there already."""
    computed: int = 0
    failed: int = 0
    """`computed` and `failed`: by this command."""
    share: float = 0.0
    """Of the work, 0 to 1."""
    seconds_left: float | None = None
    ended: Ending = ""
    """Empty while it goes on."""
    error: str = ""
    """Why it failed."""


_STATE: Kind = {
    **dict.fromkeys(("jobs", "reused", "computed", "failed"), int),
    **dict.fromkeys(("share", "seconds_left"), float),
    **dict.fromkeys(("ended", "error"), str),
}


def read_state(places: SweepPlaces) -> SweepState | None:
    """How the sweep is going; None where nobody has said yet."""
    try:
        facts = read_json(places.state)
        check_kind(facts, _STATE, str(places.state), "Start the sweep again.")
        return SweepState(**{key: facts[key] for key in _STATE if facts.get(key) is not None})
    except InputError:
        return None


def is_running(places: SweepPlaces) -> bool:
    """Whether some process is at the sweep."""
    try:
        return is_held(places.table, unsure=False)
    except ValueError:  # it is no name of a file
        return False


def stored_results(places: SweepPlaces) -> dict[str, JobResult]:
    """Every result of the journal by its job; the newest where there are several."""
    results = {}
    for entry in read_journal(places.journal):
        with suppress(InputError):  # for what else the journal tells
            result = JobResult.of_facts(entry)
            results[result.identity] = result
    return results


class SweepStore:
    """Writes the files of a sweep; one process at a time.

    Raises InputError where another process is at it, or the table belongs to something else.
    """

    def __init__(self, places: SweepPlaces) -> None:
        self.places = places
        _check_table(places.table)
        self._lock = lock_output(places.table)
        try:
            places.stop_sign.unlink(missing_ok=True)
            for path in (places.table, places.state):
                forget_unfinished(path)
            self.results = stored_results(places)
            self._journal = Journal(places.journal)
        except BaseException:
            self._lock.release()
            raise

    def keep(self, job: Job, result: JobResult) -> None:
        """Write a result to the journal."""
        told = {"recording": job.recording, "seed": job.seed, "point": job.point.by_name}
        self._journal.append({**result.facts(), **told})
        self.results[result.identity] = result

    def search_batch(self, signature: str, wanted: int) -> int:
        """Points that a search asks for at once: as many as when it was first begun.

        Other numbers would give other points, and nothing could be taken up again.
        """
        for entry in read_journal(self.places.journal):
            if entry.get("search") == signature and isinstance(entry.get("batch"), int):
                return max(1, int(entry["batch"]))
        self._journal.append({"search": signature, "batch": wanted})
        return wanted

    def stop_asked(self) -> bool:
        """Whether somebody wants the sweep to stop."""
        return self.places.stop_sign.exists()

    def note_state(self, state: SweepState) -> None:
        """Say how it is going."""
        text = json.dumps(dataclasses.asdict(state), allow_nan=False)
        write_file(self.places.state, text)

    def write_table(self, jobs: Sequence[Job]) -> None:
        """Write the table of all jobs of which something is known."""
        columns, rows = table_of(jobs, self.results)
        write_file(self.places.table, csv_text(columns, rows))

    def close(self) -> None:
        """Let others write."""
        self._journal.close()
        self.places.stop_sign.unlink(missing_ok=True)
        self._lock.release()


def table_of(
    jobs: Sequence[Job], results: dict[str, JobResult]
) -> tuple[list[str], list[list[str | float | int]]]:
    """Columns and rows of the table: a row for every job of which something is known."""
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
