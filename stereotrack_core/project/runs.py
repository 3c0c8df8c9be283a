"""Runs in a project: kept complete, listed without reading them, named, noted, deleted."""

from __future__ import annotations

import contextlib
import glob
import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from stereotrack_core.errors import InputError
from stereotrack_core.file_lock import take_lock
from stereotrack_core.interop.run_file import read_run
from stereotrack_core.interop.run_journal import PART_SUFFIX
from stereotrack_core.interop.run_npz import run_bytes, run_of_bytes
from stereotrack_core.project.edit import Change, Edit, Stamp, State
from stereotrack_core.project.entries import (
    DeleteEntry,
    Entries,
    SaveEntry,
    facts_as_json,
    row_of,
)
from stereotrack_core.project.project import Project
from stereotrack_core.project.run_facts import RunFacts, facts_to_keep, run_facts
from stereotrack_core.project.schema import RUN
from stereotrack_core.tracking.frame import Run


@dataclass(frozen=True)
class KeptRun:
    """A run of a project, without its numbers.

    Attributes
    ----------
    name : str
    content : str
        Hash of its numbers; tells runs apart whatever they are called.
    who, at : str
        Who kept it, and when.
    facts : RunFacts
    """

    name: str
    content: str
    who: str
    at: str
    facts: RunFacts


def keep_run(name: str, run: Run, note: str = "", *, replacing: bool = False) -> SaveEntry:
    """The edit that puts a complete run into the project.

    Parameters
    ----------
    name : str
        A run of that name is replaced only where that is said; see :func:`free_name`.
    note : str
        What a person has to say about it.
    """
    facts = facts_as_json(facts_to_keep(run, note))
    return SaveEntry(RUN.name, name, facts, run_bytes(run), replacing)


def delete_run(name: str) -> DeleteEntry:
    """The edit that takes a run out of the list; undoing it brings the run back."""
    return DeleteEntry(RUN.name, name)


def load_run(runs: Entries, name: str) -> Run:
    """A run of the project, bit by bit as it was kept.

    Raises
    ------
    InputError
        Where there is none of that name, or its data are no run.
    ProjectDamaged
        Where its data are not what was stored.
    """
    data = runs.data(name)
    with runs.making_sense():
        return run_of_bytes(data, name)


def kept_runs(runs: Entries) -> tuple[KeptRun, ...]:
    """All runs of a project, oldest first; their numbers are not read.

    Raises
    ------
    ProjectDamaged
        Where facts make no sense.
    """
    entries = [entry for entry in runs.all() if entry.content is not None]
    with runs.making_sense():
        return tuple(
            KeptRun(entry.name, str(entry.content), entry.who, entry.at, run_facts(entry.facts))
            for entry in entries
        )


def free_name(runs: Entries, wanted: str) -> str:
    """`wanted`, or with a number where a run has that name, or had it before it was deleted."""
    taken = {entry.name for entry in runs.all(with_deleted=True)}
    stem = wanted.strip() or "run"
    name, number = stem, 2
    while name in taken:
        name, number = f"{stem} ({number})", number + 1
    return name


@dataclass(frozen=True)
class RenameRun(Edit):
    """Give a run another name."""

    kind: ClassVar[str] = "rename"
    name: str
    new: str

    def words(self) -> str:
        """``rename run accurate to before the haircut``."""
        return f"rename run {self.name} to {self.new}"

    def changes(self, state: State, stamp: Stamp) -> Iterable[Change]:  # noqa: ARG002 - as all
        """The row under its old and under its new name; who kept it and when stay.

        Raises
        ------
        InputError
            Where there is no run of that name, the new one is empty, or another run has it.
        """
        row = row_of(state, RUN, self.name)
        if not self.new.strip():
            raise InputError("the run has no name", remedy="Give it one.")
        if self.new == self.name:
            return
        there = state.row(RUN, (self.new,))
        if there is not None and not there[-1]:
            raise InputError(f"there already is a run {self.new!r}", remedy="Choose another name.")
        yield Change(RUN, (self.name,), row, None)
        yield Change(RUN, (self.new,), there, row)


@dataclass(frozen=True)
class NoteRun(Edit):
    """Write something about a run; an empty note takes it away."""

    kind: ClassVar[str] = "note"
    name: str
    note: str

    def words(self) -> str:
        """``note on run accurate``."""
        return f"note on run {self.name}"

    def changes(self, state: State, stamp: Stamp) -> Iterable[Change]:  # noqa: ARG002 - as all
        """Its row, with other facts.

        Raises
        ------
        InputError
            Where there is no run of that name.
        """
        row = row_of(state, RUN, self.name)
        facts = json.loads(str(row[0]))
        facts.pop("note", None)
        if self.note.strip():
            facts["note"] = self.note.strip()
        yield Change(RUN, (self.name,), row, (facts_as_json(facts), *row[1:]))


def place_for_run(project: Path) -> Path:
    """A new file beside a project, for the frames of a run that is being tracked."""
    number = 1
    while (path := project.with_name(f"{project.name}.run{number}{PART_SUFFIX}")).exists():
        number += 1
    return path


def unfinished_runs(project: Path) -> tuple[Path, ...]:
    """Files of runs that nobody is tracking any more, by their names."""
    pattern = f"{glob.escape(project.name)}.run*{PART_SUFFIX}"
    return tuple(path for path in sorted(project.parent.glob(pattern)) if _is_left(path))


@dataclass(frozen=True)
class TakenIn:
    """A run that the project keeps now.

    Attributes
    ----------
    name : str
    last : int
        Its last frame.
    """

    name: str
    last: int


def take_in(project: Project, path: Path) -> TakenIn | None:
    """Keep a run that was under way, and remove its file; None where there is nothing to keep.

    Raises
    ------
    InputError
        Where the file holds something else, or the project cannot be written to; it stays then.
    """
    run = read_run(path)
    taken = None
    if len(run.frame) and not _is_kept(project, run):
        last = int(run.frame[-1])
        taken = TakenIn(free_name(project.runs, f"interrupted at frame {last}"), last)
        project.apply(keep_run(taken.name, run))
    path.unlink(missing_ok=True)
    return taken


def _is_kept(project: Project, run: Run) -> bool:
    """Whether the project has the run, because the program was killed just after keeping it."""
    known = [kept.facts for kept in kept_runs(project.runs)]
    return any(one.made == run.meta["made"] and one.frames >= len(run.frame) for one in known)


def _is_left(path: Path) -> bool:
    with contextlib.suppress(OSError), path.open("r+b") as file:
        take_lock(file)
        return True
    return False
