"""Connections to the database of a project: the one way to a file that anybody may have made."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import RLock
from typing import Any

from stereotrack_core.errors import InputError
from stereotrack_core.project.database import (
    check_header,
    check_version,
    is_in_place,
    leave_behind,
    speaking,
    transaction,
)
from stereotrack_core.project.schema import Row, Table
from stereotrack_core.project.validity import check_schema

BUSY_SECONDS = 5.0
_STRIDE = 100_000
_FREE_STEPS = 20_000_000
_STEPS_PER_BYTE = 20
"""Steps of SQLite's machine that a statement may take: so many, and more the larger the file is.

The longest statement of the program takes a quarter of a step per byte of the file.
"""

_LIMITS = {
    sqlite3.SQLITE_LIMIT_SQL_LENGTH: 20_000,
    sqlite3.SQLITE_LIMIT_COLUMN: 100,
    sqlite3.SQLITE_LIMIT_EXPR_DEPTH: 100,
    sqlite3.SQLITE_LIMIT_COMPOUND_SELECT: 2,
    sqlite3.SQLITE_LIMIT_VDBE_OP: 25_000,
    sqlite3.SQLITE_LIMIT_FUNCTION_ARG: 10,
    sqlite3.SQLITE_LIMIT_ATTACHED: 0,
    sqlite3.SQLITE_LIMIT_LIKE_PATTERN_LENGTH: 100,
    sqlite3.SQLITE_LIMIT_VARIABLE_NUMBER: 100,
    sqlite3.SQLITE_LIMIT_TRIGGER_DEPTH: 1,
}
"""Far more than statements and tables of the program need."""


class Connection(sqlite3.Connection):
    """A connection whose every statement comes to an end."""

    _path: Path
    _steps = 0

    def guard(self, path: Path) -> None:
        """Bound what statements may do, and let nothing within the file do anything."""
        self._path = path
        for kind, most in _LIMITS.items():
            self.setlimit(kind, most)
        self.set_progress_handler(self._ends, _STRIDE)
        for name, value in (("trusted_schema", "OFF"), ("cell_size_check", "ON"), ("mmap_size", 0)):
            super().execute(f"PRAGMA {name} = {value}")

    def execute(self, statement: str, values: Any = (), /) -> sqlite3.Cursor:
        """Run a statement, which has its own number of steps."""
        self._steps = 0
        return super().execute(statement, values)

    def executemany(self, statement: str, rows: Iterable[Any], /) -> sqlite3.Cursor:
        """Run a statement for each row, each with its own number of steps."""
        return super().executemany(statement, self._each(rows))

    def _each(self, rows: Iterable[Any]) -> Iterator[Any]:
        for row in rows:
            self._steps = 0
            yield row

    def _ends(self) -> bool:
        """Whether the statement that is running has to be ended."""
        self._steps += _STRIDE
        return self._steps > _FREE_STEPS and self._steps > most_steps(self._path)


def most_steps(path: Path) -> int:
    """Steps that a statement on this file may take."""
    try:
        return _FREE_STEPS + _STEPS_PER_BYTE * path.stat().st_size
    except OSError:  # it was moved away; what is open can still be read
        return _FREE_STEPS


def connect(path: Path) -> Connection:
    """Connection for reading and writing.

    Every commit is on the drive, in the one file, when it returns (``synchronous = FULL``), so
    that neither the end of the program nor a power failure takes back what was acknowledged, and a
    copy of the file alone has all of it. The rollback journal stays beside it while it is open,
    overwritten with zeros between edits: to make and delete it for every edit takes several times
    as long.

    Raises InputError where the file is no project, or not one as this program makes them;
    ProjectDamaged where it contradicts itself.
    """
    pragmas = ("journal_mode = PERSIST", "synchronous = FULL", "foreign_keys = ON")
    return _checked(path, "rw", pragmas)


def connect_for_reading(path: Path) -> Connection:
    """Connection that cannot write. Sees what another program writes to the project meanwhile.

    Raises sqlite3.OperationalError where an unfinished edit would have to be taken back first; a
    copy can be read then (:func:`copy_files`); InputError where the file is no project, or not one
    as this program makes them; ProjectDamaged where it contradicts itself.
    """
    return _checked(path, "ro")


def connect_to_rescue(path: Path) -> Connection:
    """Connection to a copy of a file about which nothing is known; only its tables may be read.

    With a schema that may be written to SQLite reads on although the list of tables makes no sense
    or the file ends too early.
    """
    database = _connected(path, "rw")
    database.execute("PRAGMA writable_schema = ON")
    return database


def _checked(path: Path, mode: str, pragmas: Iterable[str] = ()) -> Connection:
    check_header(path)
    database = _connected(path, mode)
    try:
        database.execute("SELECT 1 FROM sqlite_schema LIMIT 1").fetchone()
        with speaking(path):
            check_version(path, database.execute("PRAGMA user_version").fetchone()[0])
            check_schema(database, path)
        for pragma in pragmas:
            database.execute(f"PRAGMA {pragma}")
    except BaseException:
        database.close()
        raise
    return database


def _connected(path: Path, mode: str) -> Connection:
    database = sqlite3.connect(
        f"{path.absolute().as_uri()}?mode={mode}",
        uri=True,
        isolation_level=None,
        timeout=BUSY_SECONDS,
        check_same_thread=False,
        factory=Connection,
    )
    database.guard(path)
    return database


class Access:
    """One thread at a time; what the database complains about becomes an ``InputError``.

    `identity`: device and number of the file, by which it is known before every write.
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
            if not is_in_place(self.path, self._identity):
                leave_behind(self.path)
            yield self._database

    @contextmanager
    def writing(self) -> Iterator[sqlite3.Connection]:
        """The database within a transaction: all of the block is saved, or nothing."""
        with self.alone() as database:
            if not is_in_place(self.path, self._identity):  # nobody would find it again
                raise InputError(
                    "the project file was moved, deleted or replaced while it was open",
                    where=str(self.path),
                    remedy="The project file can no longer be saved. Save a copy; it will contain "
                    "everything up to now.",
                )
            with transaction(database):
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
