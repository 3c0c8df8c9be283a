"""Access to an open project's database for every thread, with failures in words."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import RLock
from typing import Any

from stereotrack_core.project.database import transaction
from stereotrack_core.project.failures import ProjectDamaged, speaking
from stereotrack_core.project.rows import Row, Table


class Access:
    """One thread at a time; what the database complains about becomes an ``InputError``."""

    def __init__(self, database: sqlite3.Connection, path: Path) -> None:
        self._database = database
        self._lock = RLock()
        self.path = path

    @contextmanager
    def alone(self) -> Iterator[sqlite3.Connection]:
        """The database, for this thread alone."""
        with self._lock, speaking(self.path):
            yield self._database

    @contextmanager
    def making_sense(self) -> Iterator[None]:
        """Take values that nothing can be made of for what they are: damage."""
        try:
            yield
        except (ValueError, TypeError) as error:
            raise ProjectDamaged(self.path, str(error)) from error

    @contextmanager
    def writing(self) -> Iterator[sqlite3.Connection]:
        """The database within a transaction: all of the block is saved, or nothing."""
        with self.alone() as database, transaction(database):
            yield database

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
