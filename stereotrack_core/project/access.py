"""Access to an open project's database for every thread, with failures in words."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from threading import RLock
from typing import Any

from stereotrack_core.errors import InputError
from stereotrack_core.project.database import is_in_place, leave_behind, transaction
from stereotrack_core.project.failures import making_sense, speaking
from stereotrack_core.project.rows import Row, Table


class Access:
    """One thread at a time; what the database complains about becomes an ``InputError``.

    Parameters
    ----------
    database : sqlite3.Connection
    path : Path
    identity : (int, int), optional
        Device and number of the file, by which it is known before every write.
    """

    def __init__(
        self, database: sqlite3.Connection, path: Path, identity: tuple[int, int] | None = None
    ) -> None:
        self._database = database
        self._lock = RLock()
        self._identity = identity
        self.path = path

    @contextmanager
    def alone(self) -> Iterator[sqlite3.Connection]:
        """The database, for this thread alone."""
        with self._lock, speaking(self.path):
            if not self._is_in_place():
                leave_behind(self.path)
            yield self._database

    def making_sense(self) -> AbstractContextManager[None]:
        """Take values that nothing can be made of for what they are: damage."""
        return making_sense(self.path)

    @contextmanager
    def writing(self) -> Iterator[sqlite3.Connection]:
        """The database within a transaction: all of the block is saved, or nothing."""
        with self.alone() as database:
            self._check_in_place()
            with transaction(database):
                yield database

    def _is_in_place(self) -> bool:
        return is_in_place(self.path, self._identity)

    def _check_in_place(self) -> None:
        """See that nothing is written to a file that nobody will find again."""
        if self._is_in_place():
            return
        raise InputError(
            "the project file was moved, deleted or replaced while it was open",
            where=str(self.path),
            remedy="Nothing more can be saved in it; save a copy, which has everything up to now.",
        )

    def rows(self, statement: str, values: Row = ()) -> list[Any]:
        """All rows of a SELECT."""
        with self.alone() as database:
            return database.execute(statement, values).fetchall()

    def row(self, statement: str, values: Row = ()) -> Any:
        """The first row of a SELECT, or None."""
        with self.alone() as database:
            return database.execute(statement, values).fetchone()

    def read(self, table: Table, key: Row) -> Row | None:
        """Values of the row with this key, or None."""
        with self.alone() as database:
            return table.read(database, key)
