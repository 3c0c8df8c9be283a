"""Connections to the database of a project: the one way to a file that anybody may have made."""

import os
import sqlite3
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import Event, RLock, Thread, current_thread, main_thread
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
_PATIENCE_SECONDS = 0.1  # that the window's thread waits for another one's edit
_PAUSE_SECONDS = 1.0  # after an edit, before the log is written: edits follow one another
_MOST_PAUSES = 30  # while edits go on, before the log is brought into the file all the same


def connect(path: Path) -> sqlite3.Connection:
    """Connection for reading and writing.

    Every commit is on the drive, in the one file, when it returns (``synchronous = FULL``). The
    rollback journal stays beside it while it is open, overwritten with zeros: to make and delete it
    for every edit takes several times as long. Raises InputError where the file is no project of
    this program; ProjectDamaged.
    """
    database = _checked(path, "rw", ("synchronous = FULL", "foreign_keys = ON"))
    with suppress(sqlite3.OperationalError):  # somebody still reads what was left with a log
        database.execute("PRAGMA journal_mode = PERSIST")
    return database


def connect_for_reading(path: Path) -> sqlite3.Connection:
    """Connection that cannot write. Sees what another program writes meanwhile.

    Raises sqlite3.OperationalError where an unfinished edit would have to be taken back first;
    InputError, ProjectDamaged.
    """
    return _checked(path, "ro")


def _checked(path: Path, mode: str, pragmas: Iterable[str] = ()) -> sqlite3.Connection:
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


def _connected(path: Path, mode: str) -> sqlite3.Connection:
    database = sqlite3.connect(
        f"{path.absolute().as_uri()}?mode={mode}",
        uri=True,
        isolation_level=None,
        timeout=BUSY_SECONDS,
        check_same_thread=False,
    )
    for pragma in ("trusted_schema = OFF", "cell_size_check = ON"):
        database.execute(f"PRAGMA {pragma}")
    return database


def log_edits(database: sqlite3.Connection) -> bool:
    """Append edits to a log beside the file, without waiting for the drive (0.4 ms, not 13).

    A killed program loses nothing; after a power failure the edits since :class:`LogWriter` has
    last written are missing. False where the drive cannot do this.
    """
    if database.execute("PRAGMA journal_mode = WAL").fetchone()[0] != "wal":
        return False
    pragmas = ("synchronous = NORMAL", "wal_autocheckpoint = 0", "journal_size_limit = 4194304")
    for pragma in pragmas:
        database.execute(f"PRAGMA {pragma}")
    return True


class LogWriter:
    """Writes the log of a project to the drive, and then into its file, in a thread.

    Into the file when no edit is made for a moment, as the next one has to wait for the drive then.
    """

    def __init__(self, path: Path) -> None:
        self._database = _connected(path, "rw")
        self._log = path.with_name(f"{path.name}-wal")
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
            pauses = 0
            while self._edited.is_set() and pauses < _MOST_PAUSES:
                self._edited.clear()
                if self._end.wait(_PAUSE_SECONDS):
                    return
                pauses += 1
                with suppress(OSError):  # it was moved; who writes next is told
                    file = os.open(self._log, os.O_RDWR)
                    try:
                        os.fsync(file)
                    finally:
                        os.close(file)
            with suppress(sqlite3.Error):  # the log still has it, and is tried again
                self._database.execute("PRAGMA wal_checkpoint(PASSIVE)").fetchall()


class Access:
    """One thread at a time; what the database complains about becomes an ``InputError``.

    `identity`: device and number of the file; `reader`: a second connection, where edits go to a
    log.
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
            raise InputError(
                "the project is being written to",
                where=str(self.path),
                remedy="Repeat this in a moment; the status line says what is being written.",
            )
        try:
            with speaking(self.path):
                if not is_in_place(self.path, self._identity):
                    leave_behind(self.path)
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
        waits = self._log is None or current_thread() is not main_thread()
        with self.alone(-1.0 if waits else _PATIENCE_SECONDS) as database:
            yield database

    @contextmanager
    def reading(self) -> Iterator[sqlite3.Connection]:
        """The database to be read; waits for no edit where there is a second connection."""
        if self._reader is None or self._lock.acquire(blocking=False):
            try:
                with self.alone() as database:
                    yield database
            finally:
                if self._reader is not None:
                    self._lock.release()
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
                    where=str(self.path),
                    remedy="The project file can no longer be saved. Save a copy; it will contain "
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
