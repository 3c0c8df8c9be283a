"""What an edit is: a value that says in words what it does, and does it row by row."""

from __future__ import annotations

import sqlite3
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import ClassVar

from stereotrack_core.project.rows import Change, Row, Table


@dataclass(frozen=True)
class Stamp:
    """Who makes an edit, and when (ISO 8601, UTC)."""

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

    def keys(self, table: Table, where: str, values: Row) -> Iterator[Row]:
        """Keys of the rows that satisfy a condition (a constant of the program)."""
        columns = ", ".join(table.key)
        statement = f"SELECT {columns} FROM {table.name} WHERE {where}"  # noqa: S608 - constants
        yield from self.database.execute(statement, values).fetchall()


class Edit(ABC):
    """A command; subclasses are frozen dataclasses.

    The project asks an edit for its changes once, when it is made, and keeps the rows before and
    after in the history. To undo is to write the rows before.
    """

    kind: ClassVar[str]
    """A word for edits of this kind, kept in the history."""

    @abstractmethod
    def words(self) -> str:
        """What it does, as a menu shows it after "Undo:"."""

    @abstractmethod
    def changes(self, state: State, stamp: Stamp) -> Iterable[Change]:
        """The rows that it changes.

        Raises
        ------
        InputError
            Where it makes no sense in the present state; nothing is changed then.
        """

    def contents(self) -> Iterable[bytes]:
        """Large immutable data that its rows name by :func:`content.hash_of`."""
        return ()


@dataclass(frozen=True)
class Together(Edit):
    """Several edits as one; later ones must not depend on earlier ones."""

    kind: ClassVar[str] = "together"
    text: str
    edits: tuple[Edit, ...] = field(default=())

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
