"""Rows of tables as values, and the one form that every change to a project has."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

from stereotrack_core.errors import InputError
from stereotrack_core.reading import parsed_json

Value: TypeAlias = str | int | float | None
Row: TypeAlias = tuple[Value, ...]

_VALUES = (str, int, float, type(None))


@dataclass(frozen=True)
class Table:
    """A table whose every change is kept in the history.

    Attributes
    ----------
    name : str
    key : tuple of str
        Columns that identify a row.
    values : tuple of str
        The others.
    """

    name: str
    key: tuple[str, ...]
    values: tuple[str, ...]

    @cached_property
    def columns(self) -> str:
        """Key and values, as they stand in a statement."""
        return ", ".join((*self.key, *self.values))

    @cached_property
    def _with_key(self) -> str:
        return " AND ".join(f"{column} = ?" for column in self.key)

    @cached_property
    def _select(self) -> str:
        values = ", ".join(self.values)
        return f"SELECT {values} FROM {self.name} WHERE {self._with_key}"  # noqa: S608 - no input

    @cached_property
    def _replace(self) -> str:
        marks = ", ".join("?" * (len(self.key) + len(self.values)))
        return f"INSERT OR REPLACE INTO {self.name} ({self.columns}) VALUES ({marks})"  # noqa: S608

    @cached_property
    def _delete(self) -> str:
        return f"DELETE FROM {self.name} WHERE {self._with_key}"  # noqa: S608 - no input

    def read(self, database: sqlite3.Connection, key: Row) -> Row | None:
        """Values of the row with this key, or None."""
        row: Row | None = database.execute(self._select, key).fetchone()
        return row

    def write(self, database: sqlite3.Connection, key: Row, values: Row | None) -> None:
        """Set the row with this key; None takes it away."""
        if values is None:
            database.execute(self._delete, key)
        else:
            database.execute(self._replace, (*key, *values))


@dataclass(frozen=True)
class Change:
    """What an edit does to one row.

    Attributes
    ----------
    table : Table
    key : tuple
    before, after : tuple or None
        Values of the row; None where there is no such row.
    """

    table: Table
    key: Row
    before: Row | None
    after: Row | None

    def reversed(self) -> Change:
        """The change that takes this one back."""
        return Change(self.table, self.key, self.after, self.before)


def change_of(table: Table, key: str, before: str | None, after: str | None) -> Change:
    """The change that the history keeps as JSON; ValueError where that is none of this table."""
    rows = [from_json(text) for text in (key, before, after)]
    lengths = [len(table.key), len(table.values), len(table.values)]
    if rows[0] is None or any(
        row is not None and len(row) != length for row, length in zip(rows, lengths, strict=True)
    ):
        raise ValueError(f"this is no row of {table.name}")
    return Change(table, rows[0], rows[1], rows[2])


def as_json(row: Row | None) -> str | None:
    """Text of a row; floating-point numbers come back bit by bit."""
    return None if row is None else json.dumps(row, allow_nan=False, separators=(",", ":"))


def from_json(text: str | None) -> Row | None:
    """The row of :func:`as_json`; ValueError for anything else."""
    if text is None:
        return None
    try:
        row = json.loads(text)
    except RecursionError as error:
        raise ValueError("this is no row") from error
    if not isinstance(row, list) or not all(isinstance(one, _VALUES) for one in row):
        raise ValueError("this is no row")
    return tuple(row)


def facts_of(text: str) -> dict[str, Any]:
    """Plain data by name, as JSON; ValueError where they cannot be of this program."""
    try:
        facts = parsed_json(text, "facts")
    except InputError as error:
        raise ValueError(error.what) from error
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
