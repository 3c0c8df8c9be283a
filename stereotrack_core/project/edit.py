"""Edits: values that say in words what they do, and do it row by row."""

import json
import sqlite3
from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, ClassVar

from stereotrack_core.project.schema import Row, Table
from stereotrack_core.reading import parsed_json

_VALUES = (str, int, float, type(None))


@dataclass(frozen=True)
class Change:
    """Change of one row by an edit; None where there is no such row."""

    table: Table
    key: Row
    before: Row | None
    after: Row | None


def change_of(table: Table, key: str, before: str | None, after: str | None) -> Change:
    """The change that the history keeps as JSON; ValueError where that is none of this table."""
    rows = [_from_json(text) for text in (key, before, after)]
    lengths = [len(table.key), len(table.values), len(table.values)]
    if rows[0] is None or any(
        row is not None and len(row) != length for row, length in zip(rows, lengths, strict=True)
    ):
        raise ValueError(f"this is not a row of {table.name}")
    return Change(table, rows[0], rows[1], rows[2])


def as_json(row: Row | None) -> str | None:
    """Text of a row; floating-point numbers come back bit by bit."""
    return None if row is None else json.dumps(row, allow_nan=False, separators=(",", ":"))


def _from_json(text: str | None) -> Row | None:
    if text is None:
        return None
    try:
        row = json.loads(text)
    except RecursionError as error:
        raise ValueError("this is not a row") from error
    if not isinstance(row, list) or not all(isinstance(one, _VALUES) for one in row):
        raise ValueError("this is not a row")
    return tuple(row)


def facts_of(text: str) -> dict[str, Any]:
    """Plain data by name, as JSON; ValueError, InputError where they cannot be of this program."""
    facts = parsed_json(text, "facts")
    if not isinstance(facts, dict):
        raise ValueError("facts have no names")
    return facts


def without_idle(changes: Iterable[Change]) -> tuple[Change, ...]:
    """The changes that change something, one for each row; the last one to touch a row wins."""
    merged: dict[tuple[str, Row], Change] = {}
    for change in changes:
        place = (change.table.name, change.key)
        first = merged.get(place)
        before = change.before if first is None else first.before
        merged[place] = Change(change.table, change.key, before, change.after)
    return tuple(change for change in merged.values() if change.before != change.after)


@dataclass(frozen=True)
class Stamp:
    """Author and time (ISO 8601, UTC) of an edit."""

    who: str
    at: str


@dataclass(frozen=True, eq=False)
class State:
    """The project as it is before an edit, to be read by the edit."""

    database: sqlite3.Connection

    def row(self, table: Table, key: Row) -> Row | None:
        """Values of a row, or None."""
        return table.read(self.database, key)

    def change(self, table: Table, key: Row, after: Row | None) -> Change:
        """The change that leads to `after`."""
        return Change(table, key, self.row(table, key), after)


class Edit(ABC):
    """A command; subclasses are frozen dataclasses.

    An edit is asked for its changes once; the rows before and after are kept in the history.
    """

    kind: ClassVar[str]  # a word for edits of this kind, kept in the history

    @abstractmethod
    def words(self) -> str:
        """Description, as a menu shows it after "Undo:"."""

    @abstractmethod
    def changes(self, state: State, stamp: Stamp) -> Iterable[Change]:
        """The rows that it changes. Raises InputError where it makes no sense."""

    def contents(self) -> Iterable[bytes]:
        """Large immutable data that its rows name by :func:`entries.hash_of`."""
        return ()


@dataclass(frozen=True)
class Together(Edit):
    """Several edits as one; later ones must not depend on earlier ones."""

    kind: ClassVar[str] = "together"
    text: str
    edits: tuple[Edit, ...] = ()

    def words(self) -> str:
        """The text that it was given."""
        return self.text

    def changes(self, state: State, stamp: Stamp) -> Iterable[Change]:
        """The changes of all of them."""
        for edit in self.edits:
            yield from edit.changes(state, stamp)

    def contents(self) -> Iterable[bytes]:
        """The contents of all of them."""
        for edit in self.edits:
            yield from edit.contents()
