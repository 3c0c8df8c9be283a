"""Connections to the database of a project: one that writes, or any number that read."""

from __future__ import annotations

import sqlite3
from pathlib import Path

from stereotrack_core.project.database import has_log

BUSY_SECONDS = 5.0


def connect(path: Path) -> sqlite3.Connection:
    """Connection for reading and writing.

    Every commit is on the drive, in the one file, when it returns (``synchronous = FULL``), so
    that neither the end of the program nor a power failure takes back what was acknowledged, and a
    copy of the file alone has all of it. The rollback journal stays beside it while it is open,
    overwritten with zeros between edits: to make and delete it for every edit takes several times
    as long. A write-ahead log, which older programs kept, is taken into the file first.
    """
    log = has_log(path)
    database = _connection(path, "rw")
    try:
        if log:
            _take_in_log(database)
        database.execute("PRAGMA journal_mode = PERSIST")
        database.execute("PRAGMA synchronous = FULL")
        database.execute("PRAGMA foreign_keys = ON")
    except BaseException:
        database.close()
        raise
    return database


def _take_in_log(database: sqlite3.Connection) -> None:
    database.execute("PRAGMA locking_mode = EXCLUSIVE")  # reads a log without shared memory
    database.execute("PRAGMA journal_mode = DELETE")
    database.execute("PRAGMA locking_mode = NORMAL")
    database.execute("BEGIN IMMEDIATE")  # all this takes effect, or fails, with the first lock
    database.execute("ROLLBACK")


def connect_for_reading(path: Path) -> sqlite3.Connection:
    """Connection that cannot write. Sees what another program writes to the project meanwhile.

    Raises
    ------
    sqlite3.OperationalError
        Where an unfinished edit would have to be taken back first, or a log needs memory that
        cannot be shared there; a copy can be read then (:func:`copy_files`).
    """
    database = _connection(path, "ro")
    try:
        database.execute("SELECT count(*) FROM sqlite_schema").fetchone()
    except sqlite3.Error:
        database.close()
        raise
    return database


def _connection(path: Path, mode: str) -> sqlite3.Connection:
    return sqlite3.connect(
        f"{path.absolute().as_uri()}?mode={mode}",
        uri=True,
        isolation_level=None,
        timeout=BUSY_SECONDS,
        check_same_thread=False,
    )
