"""Edits: values that say in words what they do, and do it row by row."""

import json
import sqlite3
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any

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
    own, *both = (_from_json(text) for text in (key, before, after))
    if own is None or any(row is not None and len(row) != len(table.values) for row in both):
        raise ValueError(f"this is not a row of {table.name}")
    return Change(table, own, *both)


def as_json(row: Row | None) -> str | None:
    """Text of a row; floating-point numbers come back bit by bit."""
    return None if row is None else json.dumps(row, allow_nan=False, separators=(",", ":"))


def _from_json(text: str | None) -> Row | None:
    row = None if text is None else json.loads(text)
    if row is None:
        return None
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


@dataclass(frozen=True, eq=False)
class Edit:
    """A command, made by a function; the rows before and after it are kept in the history."""

    kind: str  # a word for edits of this kind, kept in the history
    words: str  # description, as a menu shows it after "Undo:"
    changes: Callable[[State, Stamp], Iterable[Change]]
    """The rows that it changes; called once. Raises InputError where it makes no sense."""
    contents: tuple[bytes, ...] = ()  # large data that its rows name by :func:`entries.hash_of`


def together(words: str, edits: Sequence[Edit]) -> Edit:
    """Several edits as one; later ones must not depend on earlier ones."""

    def changes(state: State, stamp: Stamp) -> Iterable[Change]:
        return chain.from_iterable(edit.changes(state, stamp) for edit in edits)

    contents = chain.from_iterable(edit.contents for edit in edits)
    return Edit("together", words, changes, tuple(contents))
