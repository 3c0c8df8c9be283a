"""Connections to the database of a project: the one way to a file that anybody may have made."""

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import Event, RLock, Thread, current_thread, main_thread
from typing import Any

from stereotrack_core.errors import InputError
from stereotrack_core.project.database import (
    beside,
    check_header,
    check_schema,
    check_version,
    code_of,
    is_in_place,
    speaking,
    transaction,
)
from stereotrack_core.project.schema import Row, Table

BUSY_SECONDS = 5.0
_PATIENCE_SECONDS = 0.1  # that the window's thread waits for another one's edit
_PAUSE_SECONDS = 1.0  # without an edit, after which the log is brought into the file


def connect(path: Path) -> sqlite3.Connection:
    """Connection for reading and writing. Raises InputError for no project; ProjectDamaged."""
    database = _checked(path, "rw")
    database.execute("PRAGMA foreign_keys = ON")
    return database


def set_log(database: sqlite3.Connection, *, log: bool) -> None:
    """Append edits to a log beside the file (``-wal``): no edit waits for the drive or for readers.

    A killed program loses nothing. :class:`LogWriter` brings the log onto the drive. Drives of a
    network cannot share a log; there an edit is on the drive at once.
    """
    with suppress(sqlite3.OperationalError):  # somebody still reads what was left with a log
        database.execute(f"PRAGMA journal_mode = {'WAL' if log else 'DELETE'}")
    database.execute(f"PRAGMA synchronous = {'NORMAL' if log else 'FULL'}")
    if log:
        database.execute("PRAGMA wal_autocheckpoint = 0")
        # A connection that has not read since cannot bring the log in ("table is locked").
        database.execute("SELECT 1 FROM sqlite_schema LIMIT 1").fetchone()


class LogWriter:
    """Brings the log of a project into its file, in a thread: no edit waits for the drive.

    That takes 20 to 100 ms, an edit of the log 0.1. A killed program loses nothing, a power failure
    what was edited since the last pause.
    """

    def __init__(self, path: Path) -> None:
        self._database = _checked(path, "rw")
        self._edited, self._end = Event(), Event()
        self._thread = Thread(target=self._work, name="project log", daemon=True)
        self._thread.start()

    def soon(self) -> None:
        """Take note of an edit."""
        self._edited.set()

    def close(self) -> None:
        """End the thread; who closes the project brings in what is left."""
        self._end.set()
        self._edited.set()
        self._thread.join()
        self._database.close()

    def _work(self) -> None:
        while self._edited.wait() and not self._end.is_set():
            self._edited.clear()
            # In a pause: the first edit after it has to wait for the drive.
            if not self._edited.wait(_PAUSE_SECONDS):
                with suppress(sqlite3.Error):  # the log still has it, and is tried again
                    self._database.execute("PRAGMA wal_checkpoint(PASSIVE)").fetchall()


def connect_for_reading(path: Path) -> sqlite3.Connection:
    """Connection that cannot write, and sees another's edits. Raises InputError, ProjectDamaged."""
    try:
        return _checked(path, "ro")
    except sqlite3.OperationalError as error:
        if code_of(error) not in (sqlite3.SQLITE_CANTOPEN, sqlite3.SQLITE_READONLY):
            raise
        if beside(path):
            what = "its newest edits are beside it and cannot be read here"
            remedy = "Open it for writing once, or copy these files to a folder of your own."
            raise InputError(what, path, remedy) from error
    return _checked(path, "ro&immutable=1")  # in a folder where no log can be made


def _checked(path: Path, mode: str) -> sqlite3.Connection:
    check_header(path)
    database = sqlite3.connect(
        f"{path.absolute().as_uri()}?mode={mode}",
        uri=True,
        isolation_level=None,
        timeout=BUSY_SECONDS,
        check_same_thread=False,
    )
    try:
        for pragma in ("trusted_schema = OFF", "cell_size_check = ON"):
            database.execute(f"PRAGMA {pragma}")
        database.execute("SELECT 1 FROM sqlite_schema LIMIT 1").fetchone()
        with speaking(path):
            check_version(path, database.execute("PRAGMA user_version").fetchone()[0])
            check_schema(database, path)
    except BaseException:
        database.close()
        raise
    return database


class Access:
    """One thread at a time; what the database complains about becomes an ``InputError``.

    `identity`: device and number of the file; `reader`, `log`: where edits go to a log, a second
    connection and who brings it into the file.
    """

    def __init__(
        self,
        database: sqlite3.Connection,
        path: Path,
        identity: tuple[int, int] | None = None,
        reader: sqlite3.Connection | None = None,
        log: LogWriter | None = None,
    ) -> None:
        self._database, self._reader, self._log = database, reader, log
        self._lock, self._reading = RLock(), RLock()
        self._identity = identity
        self.path = path

    @contextmanager
    def alone(self, seconds: float = -1.0) -> Iterator[sqlite3.Connection]:
        """The database, for this thread alone; InputError after waiting so long, -1: for ever."""
        if not self._lock.acquire(timeout=seconds):
            remedy = "Repeat this in a moment; the status line says what is being written."
            raise InputError("the project is being written to", self.path, remedy)
        try:
            with speaking(self.path):
                yield self._database
        finally:
            self._lock.release()

    @contextmanager
    def for_nobody_else(self) -> Iterator[None]:
        """Let no other thread read either: closing what it reads from would end the program."""
        with self.alone(), self._reading:
            yield

    @contextmanager
    def at_once(self) -> Iterator[sqlite3.Connection]:
        """The database; the window's thread does not wait for a long edit of another one."""
        waits = current_thread() is not main_thread()
        with self.alone(-1.0 if waits else _PATIENCE_SECONDS) as database:
            yield database

    @contextmanager
    def reading(self) -> Iterator[sqlite3.Connection]:
        """The database to be read; waits for no edit where there is a second connection."""
        if self._reader is None:
            with self.alone() as database:
                yield database
        else:
            with self._reading, speaking(self.path):
                yield self._reader

    @contextmanager
    def writing(self) -> Iterator[sqlite3.Connection]:
        """The database within a transaction: all of the block is saved, or nothing."""
        with self.alone() as database:
            if not is_in_place(self.path, self._identity):  # nobody would find it again
                raise InputError(
                    "the project file was moved, deleted or replaced while it was open",
                    self.path,
                    "The project file can no longer be saved. Save a copy; it will contain "
                    "everything up to now.",
                )
            with transaction(database):
                yield database
            if self._log is not None:
                self._log.soon()

    def rows(self, statement: str, values: Row = ()) -> list[Any]:
        """All rows of a SELECT."""
        with self.reading() as database:
            return database.execute(statement, values).fetchall()

    def row(self, statement: str, values: Row = ()) -> Any:
        """The first row of a SELECT, or None."""
        with self.reading() as database:
            return database.execute(statement, values).fetchone()

    def read(self, table: Table, key: Row) -> Row | None:
        """Values of the row with this key, or None."""
        with self.reading() as database:
            return table.read(database, key)
