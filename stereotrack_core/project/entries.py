"""Named things of a project: references, subjects, sets of landmarks and parameters."""

import hashlib
import json
import sqlite3
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from stereotrack_core.annotation.landmark_set import NINE, LandmarkSet, landmark_set_of
from stereotrack_core.annotation.reference import Reference
from stereotrack_core.errors import InputError
from stereotrack_core.interop.reference_npz import reference_bytes, reference_of_bytes
from stereotrack_core.project.connection import Access
from stereotrack_core.project.database import ProjectDamaged, making_sense
from stereotrack_core.project.edit import Change, Edit, Stamp, State, facts_of
from stereotrack_core.project.schema import (
    CHOICE,
    LANDMARK_SET,
    PARAMETER_SET,
    REFERENCE,
    SUBJECT,
    Row,
    Table,
)
from stereotrack_core.recording.description import LENGTHS, Subject, subject_in


def hash_of(data: bytes) -> str:
    """Name under which content is kept: BLAKE2b, 32 hexadecimal digits."""
    return hashlib.blake2b(data, digest_size=16).hexdigest()


def store(database: sqlite3.Connection, contents: Iterable[bytes]) -> None:
    """Keep contents, each once; they stay when an edit is undone, so that it can be redone."""
    for data in contents:
        database.execute("INSERT OR IGNORE INTO content VALUES (?, ?)", (hash_of(data), data))


def fetch(database: sqlite3.Connection, path: Path, name: str) -> bytes:
    """Content of that hash, verified. Raises ProjectDamaged."""
    row = database.execute("SELECT bytes FROM content WHERE hash = ?", (name,)).fetchone()
    if row is None or hash_of(row[0]) != name:
        raise ProjectDamaged(path, f"the stored data {name} are missing or damaged")
    data: bytes = row[0]
    return data


@dataclass(frozen=True)
class Entry:
    """A named thing, without its large data, of which it has the hash; who saved it, and when."""

    name: str
    facts: Mapping[str, Any]
    content: str | None
    who: str
    at: str
    deleted: bool


class Entries:
    """The named things of one table."""

    def __init__(self, table: Table, access: Access) -> None:
        self.table, self.path = table, access.path
        self._access = access

    def names(self) -> tuple[str, ...]:
        """Names, oldest first."""
        return tuple(entry.name for entry in self.all())

    def all(self, *, with_deleted: bool = False) -> tuple[Entry, ...]:
        """All of them, oldest first."""
        condition = "" if with_deleted else "WHERE deleted = 0"
        rows = self._access.rows(
            f"SELECT {self.table.columns} FROM {self.table.name} {condition}"  # noqa: S608
            " ORDER BY at, name"
        )
        with making_sense(self.path, InputError):
            return tuple(_entry(row[0], row[1:]) for row in rows)

    def get(self, name: str) -> Entry:
        """The one of that name; InputError where there is none."""
        values = self._access.read(self.table, (name,))
        with making_sense(self.path, InputError):
            entry = None if values is None else _entry(name, values)
        if entry is None or entry.deleted:
            raise _missing(self.table, name)
        return entry

    def data(self, name: str) -> bytes:
        """The large data of the one of that name. Raises InputError without any."""
        entry = self.get(name)
        if entry.content is None:
            what = "its data are missing"
            raise InputError(what, f"{self.table.word} {name}", "Delete it and save it again.")
        with self._access.reading() as database:
            return fetch(database, self.path, entry.content)


def save_entry(
    table: Table, name: str, facts: str, data: bytes | None = None, *, replacing: bool = False
) -> Edit:
    """Save a named thing; one of that name is replaced only where that is said."""
    content = None if data is None else hash_of(data)

    def changes(state: State, stamp: Stamp) -> Iterable[Change]:
        if not name.strip():
            raise InputError(f"the {table.word} has no name", remedy="Give it one.")
        before = state.row(table, (name,))
        if before is not None and not before[-1] and not replacing:
            remedy = "Choose another name, or confirm that it is to be replaced."
            raise InputError(f"there is a {table.word} {name!r} already", remedy=remedy)
        if before is None or (*before[:2], before[-1]) != (facts, content, 0):
            yield Change(table, (name,), before, (facts, content, stamp.who, stamp.at, 0))

    contents = () if data is None else (data,)
    return Edit("save", f"save {table.word} {name}", changes, contents)


def delete_entry(table: Table, name: str) -> Edit:
    """Take a named thing away; its data stay in the file, so that it can come back."""

    def changes(state: State, stamp: Stamp) -> Iterable[Change]:
        before = row_of(state, table, name)
        yield Change(table, (name,), before, (*before[:2], stamp.who, stamp.at, 1))

    return Edit("delete", f"delete {table.word} {name}", changes)


def choose(table: Table, name: str | None) -> Edit:
    """Say which of a table's named things is used, or with None that none is."""

    def changes(state: State, _stamp: Stamp) -> Iterable[Change]:
        if name is not None:
            row_of(state, table, name)
        yield state.change(CHOICE, (table.name,), None if name is None else (name,))

    words = f"use no {table.word}" if name is None else f"use {table.word} {name}"
    return Edit("choose", words, changes)


def row_of(state: State, table: Table, name: str) -> Row:
    """Row of a named thing; InputError where there is none of that name."""
    row = state.row(table, (name,))
    if row is None or row[-1]:
        raise _missing(table, name)
    return row


def facts_as_json(facts: Mapping[str, Any]) -> str:
    """Facts as they are stored."""
    return json.dumps(dict(facts), sort_keys=True, separators=(",", ":"))


def _entry(name: Any, values: Row) -> Entry:
    facts, content, who, at, deleted = values
    return Entry(name, facts_of(str(facts)), content, who, at, bool(deleted))  # type: ignore[arg-type]


def _missing(table: Table, name: str) -> InputError:
    return InputError(
        f"the project has no {table.word} {name!r}", remedy="Choose one of those listed."
    )


class ViewSettings:
    """Values by name, JSON-serialisable: the frame shown last, switches, filters."""

    def __init__(self, access: Access) -> None:
        self._access = access

    def get(self, name: str, default: Any = None) -> Any:
        """Value of that name; `default` where there is none of its kind."""
        row = self._access.row("SELECT value FROM view_setting WHERE name = ?", (name,))
        try:
            value = None if row is None else json.loads(row[0])
        except ValueError:
            value = None
        kinds = (int, float) if isinstance(default, float) else type(default)
        return value if default is None or isinstance(value, kinds) else default

    def set(self, name: str, value: Any) -> None:
        """Keep a value; None forgets it."""
        text = json.dumps(value)
        with self._access.writing() as database:
            if value is None:
                database.execute("DELETE FROM view_setting WHERE name = ?", (name,))
            else:
                database.execute("INSERT OR REPLACE INTO view_setting VALUES (?, ?)", (name, text))


@dataclass(frozen=True)
class ParameterSet:
    """Parameters by name, JSON-serialisable, as they differ from a preset."""

    preset: str
    values: Mapping[str, Any]


_META_SHOWN = ("program", "version", "preset", "seed", "recording", "fingerprint", "views")


def save_reference(name: str, reference: Reference, *, replacing: bool = False) -> Edit:
    """The edit that puts a reference into the project."""
    shown = {key: reference.meta[key] for key in _META_SHOWN if key in reference.meta}
    facts = facts_as_json({"frames": len(reference.frame), **shown})
    return save_entry(REFERENCE, name, facts, reference_bytes(reference), replacing=replacing)


def load_reference(references: Entries, name: str) -> Reference:
    """A reference of the project, bit by bit as saved. Raises InputError, ProjectDamaged."""
    data = references.data(name)
    with making_sense(references.path):
        return reference_of_bytes(data, name)


def save_subject(subject: Subject, *, origin: str = "entered") -> Edit:
    """The edit that keeps a subject; `origin`: ``measured from clicks``, ``personalised`` ..."""
    facts = {**asdict(subject), "origin": origin}
    return save_entry(SUBJECT, subject.name, facts_as_json(facts), replacing=True)


def use_subject(subject: Subject, origin: str) -> Edit:
    """Keep a subject under its name, and let the project use it, as one edit."""
    saved = save_subject(subject, origin=origin)

    def changes(state: State, stamp: Stamp) -> Iterable[Change]:
        yield from saved.changes(state, stamp)
        yield state.change(CHOICE, (SUBJECT.name,), (subject.name,))

    return Edit("use subject", f"use subject {subject.name}, {origin}", changes)


def load_subject(subjects: Entries, name: str) -> Subject:
    """A subject of the project; InputError where there is none of that name."""
    facts = subjects.get(name).facts
    known = {key: facts[key] for key in (*LENGTHS, "offsets") if facts.get(key) is not None}
    with making_sense(subjects.path, InputError):
        return replace(subject_in(known, "subject"), name=name)


def save_landmark_set(landmarks: LandmarkSet) -> Edit:
    """The edit that keeps a set of landmarks under its name."""
    facts = facts_as_json(landmarks.facts())
    return save_entry(LANDMARK_SET, landmarks.name, facts, replacing=True)


def load_landmark_set(sets: Entries, name: str | None) -> LandmarkSet:
    """A set of landmarks of the project, the nine without a name. Raises InputError."""
    if name is None or (name == NINE.name and name not in sets.names()):
        return NINE
    facts = sets.get(name).facts
    with making_sense(sets.path, InputError):
        return landmark_set_of(facts)


def save_parameters(name: str, parameters: ParameterSet) -> Edit:
    """The edit that keeps parameters under a name."""
    facts = facts_as_json({"preset": parameters.preset, "values": dict(parameters.values)})
    return save_entry(PARAMETER_SET, name, facts, replacing=True)


def load_parameters(sets: Entries, name: str) -> ParameterSet:
    """Parameters of the project; InputError where there are none of that name."""
    facts = sets.get(name).facts
    with making_sense(sets.path):
        return ParameterSet(str(facts["preset"]), dict(facts["values"]))
