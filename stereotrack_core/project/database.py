"""Open the database of a project: safely on every drive, or for reading only."""

from __future__ import annotations

import shutil
import sqlite3
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from stereotrack_core.atomic import replacing
from stereotrack_core.errors import InputError
from stereotrack_core.project.failures import ProjectDamaged, code_of, speaking
from stereotrack_core.project.rows import Row
from stereotrack_core.project.schema import APPLICATION, FORMAT, STATEMENTS

BUSY_SECONDS = 5.0
_MAGIC = b"SQLite format 3\0"
_HEADER = 100
_VERSION_AT, _APPLICATION_AT = 60, 68
_NO_SHARED_MEMORY = (sqlite3.SQLITE_CANTOPEN, sqlite3.SQLITE_IOERR, sqlite3.SQLITE_READONLY)
"""What SQLite says where it cannot make or map the memory that a write-ahead log needs."""


def make_database(path: Path, recording: Row | None = None) -> None:
    """Make an empty project; either all of it is there afterwards, or nothing.

    Parameters
    ----------
    path : Path
        Its folder is made where it is not there.
    recording : tuple of str, optional
        Name, relative path, absolute path and fingerprint.

    Raises
    ------
    InputError
        Where something of that name exists, or the place cannot be written to.
    """
    if path.exists():
        raise InputError(
            "there is a file of that name already",
            where=str(path),
            remedy="Open it, or choose another name for the new project.",
        )
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"the folder cannot be made ({error.strerror})",
            where=str(path.parent),
            remedy="Choose another place.",
        ) from error
    with replacing(path) as temporary, speaking(path):
        database = sqlite3.connect(temporary, isolation_level=None)
        try:
            with transaction(database):
                for statement in STATEMENTS:
                    database.execute(statement)
                if recording is not None:
                    database.execute("INSERT INTO recording VALUES (1, ?, ?, ?, ?)", recording)
                database.execute(f"PRAGMA user_version = {FORMAT}")
                database.execute(f"PRAGMA application_id = {APPLICATION}")
        finally:
            database.close()


def check_header(path: Path) -> None:
    """See from the first bytes alone that the file is a project that this program knows.

    Raises
    ------
    InputError
        Where there is no file, it is not a project, or a newer program wrote it.
    ProjectDamaged
        Where it was cut off.
    """
    try:
        with path.open("rb") as file:
            header = file.read(_HEADER)
    except FileNotFoundError:
        raise InputError(
            "there is no such file",
            where=str(path),
            remedy="Correct the path. The workbench makes a project beside a recording that is "
            "opened in it: `stereotrack open RECORDING`.",
        ) from None
    except OSError as error:
        raise InputError(
            f"it cannot be read ({error.strerror})",
            where=str(path),
            remedy="Give a project file that you have the right to read.",
        ) from error
    if not header:
        raise InputError("the file is empty", where=str(path), remedy="Make a new project.")
    if not header.startswith(_MAGIC[: len(header)]):
        raise no_project(path)
    if len(header) < _HEADER:
        raise ProjectDamaged(path, f"it ends after {len(header)} bytes")
    (version,) = struct.unpack_from(">i", header, _VERSION_AT)
    (application,) = struct.unpack_from(">i", header, _APPLICATION_AT)
    if application != APPLICATION:
        raise no_project(path)
    check_version(path, version)


def check_version(path: Path, version: int) -> None:
    """Refuse what a newer program wrote."""
    if version > FORMAT:
        raise InputError(
            f"a newer program wrote it (format {version}, this one knows up to {FORMAT})",
            where=str(path),
            remedy="Open it with that program; nothing was changed.",
        )


def no_project(path: Path) -> InputError:
    """The complaint about a file that is something else."""
    return InputError(
        "this is not a project of this program",
        where=str(path),
        remedy="Give a file that ends in .stereotrack.",
    )


def version_of(database: sqlite3.Connection) -> int:
    """Format that the database says it has."""
    version: int = database.execute("PRAGMA user_version").fetchone()[0]
    return version


def connect(path: Path, *, safe: bool) -> tuple[sqlite3.Connection, str]:
    """Connection for reading and writing, and its journal: ``wal`` or ``delete``.

    Every commit is on the drive when it returns (``synchronous = FULL``), so that neither the
    end of the program nor a power failure takes back what was acknowledged.

    Parameters
    ----------
    path : Path
    safe : bool
        Do without the write-ahead log, which needs memory that all its users share. That is also
        done where the drive turns out not to have such memory.
    """
    database = sqlite3.connect(
        f"{path.absolute().as_uri()}?mode=rw",
        uri=True,
        isolation_level=None,
        timeout=BUSY_SECONDS,
        check_same_thread=False,
    )
    try:
        journal = _journal(database, safe)
        database.execute("PRAGMA synchronous = FULL")
        database.execute("PRAGMA foreign_keys = ON")
    except sqlite3.OperationalError as error:
        database.close()
        if safe or code_of(error) not in _NO_SHARED_MEMORY:
            raise
        return connect(path, safe=True)
    except BaseException:
        database.close()
        raise
    return database, journal


def _journal(database: sqlite3.Connection, safe: bool) -> str:
    """Choose the journal before anything else is read; ``wal`` or ``delete``."""
    if safe:
        database.execute("PRAGMA locking_mode = EXCLUSIVE")  # reads a log without shared memory
    wanted = "DELETE" if safe else "WAL"
    journal = database.execute(f"PRAGMA journal_mode = {wanted}").fetchone()[0]
    database.execute("PRAGMA locking_mode = NORMAL")
    database.execute("BEGIN IMMEDIATE")  # all this takes effect, or fails, with the first lock
    database.execute("ROLLBACK")
    return str(journal)


def connect_for_reading(path: Path) -> sqlite3.Connection:
    """Connection that cannot write. Sees what another program writes to the project meanwhile.

    Raises
    ------
    sqlite3.OperationalError
        Where the folder is read-only too, so that SQLite has no place for its shared memory;
        a copy can be read then (:func:`copy_files`).
    """
    database = sqlite3.connect(
        f"{path.absolute().as_uri()}?mode=ro",
        uri=True,
        isolation_level=None,
        timeout=BUSY_SECONDS,
        check_same_thread=False,
    )
    try:
        database.execute("SELECT count(*) FROM sqlite_schema").fetchone()
    except sqlite3.Error:
        database.close()
        raise
    return database


def copy_files(path: Path, folder: Path) -> Path:
    """Copy a project with what is in its log but not in the file yet; the path of the copy."""
    shutil.copyfile(path, folder / path.name)
    for suffix in ("-wal", "-journal"):
        source = path.with_name(path.name + suffix)
        if source.exists():
            shutil.copyfile(source, folder / source.name)
    return folder / path.name


@contextmanager
def transaction(database: sqlite3.Connection) -> Iterator[None]:
    """All of the block or, when it raises, nothing of it."""
    database.execute("BEGIN IMMEDIATE")
    try:
        yield
        database.execute("COMMIT")
    except BaseException:
        if database.in_transaction:
            database.execute("ROLLBACK")
        raise
