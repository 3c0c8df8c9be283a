"""The database of a project as a file: made, known by its first bytes, copied, changed at once."""

import glob
import os
import sqlite3
import struct
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from stereotrack_core.atomic import make_folder, replacing
from stereotrack_core.errors import InputError, shortened
from stereotrack_core.project.schema import (
    ADDED_STATEMENTS,
    APPLICATION,
    FORMAT,
    OLDEST_FORMAT,
    STATEMENTS,
    Row,
)
from stereotrack_core.reading import open_file

_PRIMARY = 0xFF  # the part of SQLite's result codes that names the kind of failure
_SENTENCES: dict[int, tuple[str, str]] = {
    sqlite3.SQLITE_BUSY: (
        "another program is reading or writing it",
        "Close the project there or wait, then repeat the last edit; it was not made.",
    ),
    sqlite3.SQLITE_FULL: (
        "there is no space left on the drive",
        "Free space and repeat the last edit. All earlier edits are saved.",
    ),
    sqlite3.SQLITE_READONLY: (
        "it is write-protected",
        "Change the permissions of the file, or open it read-only.",
    ),
    sqlite3.SQLITE_CANTOPEN: (
        "it cannot be opened",
        "Check that the drive is connected and that you may read the file.",
    ),
    sqlite3.SQLITE_IOERR: (
        "the drive reports an error",
        "Check the drive. All edits before the last one are saved.",
    ),
    sqlite3.SQLITE_NOMEM: (
        "there is not enough memory",
        "Close other programs. All edits before the last one are saved.",
    ),
}

_NONSENSE = (ValueError, TypeError, LookupError, OverflowError, RecursionError)
"""Exceptions raised by senseless values."""

_DAMAGE = (
    *(sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB, sqlite3.SQLITE_CONSTRAINT),
    *(sqlite3.SQLITE_MISMATCH, sqlite3.SQLITE_TOOBIG, sqlite3.SQLITE_ERROR),
)
"""Result codes that only a damaged file gives."""


def how_to_restore(path: Path) -> str:
    """Remedy for a damaged project: the backup beside it, and how to open it."""
    kept = sorted(path.parent.glob(f"{glob.escape(path.stem)}.format*{path.suffix}"))
    if not kept:
        return (
            "Open a copy made with File, Project, Save a copy, or one from a backup of the drive. "
            "This file is not changed."
        )
    return (
        f"Open its backup with File, Open a project, or `stereotrack open {kept[-1]}`: the "
        "project as it was before it got the present format. This file is not changed."
    )


class ProjectDamaged(InputError):
    """The project cannot be read; `detail` says why, `first` what to do before a backup is used."""

    def __init__(self, path: Path, detail: str, first: str = "") -> None:
        super().__init__(
            f"the project file is damaged ({detail})",
            where=str(path),
            remedy=f"{first} {how_to_restore(path)}".strip(),
        )
        self.detail = detail


class ProjectInUse(InputError):
    """Another program has the project open for writing; it can still be read."""


def code_of(error: sqlite3.Error) -> int:
    """SQLite's primary result code; 0 where Python itself complains."""
    return getattr(error, "sqlite_errorcode", 0) & _PRIMARY


@contextmanager
def speaking(path: Path) -> Iterator[None]:
    """Turn failures of the database into sentences about `path`: ProjectDamaged, InputError."""
    try:
        yield
    except UnicodeDecodeError as error:  # in a message about a list of tables that is rubbish
        raise ProjectDamaged(path, "its list of tables cannot be read") from error
    except sqlite3.Error as error:
        kind = code_of(error)
        if kind in _DAMAGE or (not kind and "decode" in str(error)):
            raise ProjectDamaged(path, str(error)) from error
        if kind not in _SENTENCES:
            raise
        what, remedy = _SENTENCES[kind]
        raise InputError(what, where=str(path), remedy=remedy) from error


@contextmanager
def making_sense(path: Path, *also: type[InputError]) -> Iterator[None]:
    """Take senseless values of the file for damage, and errors of these kinds; ProjectDamaged."""
    kinds: tuple[type[Exception], ...] = (*_NONSENSE, *also)
    with speaking(path):
        try:
            yield
        except kinds as error:
            said = shortened(error.what if isinstance(error, InputError) else str(error))
            what = f"{said} is missing" if isinstance(error, KeyError) else said
            raise ProjectDamaged(path, what) from error


_MAGIC = b"SQLite format 3\0"
_HEADER = 100
_VERSION_AT, _APPLICATION_AT = 60, 68
_PAGE_SIZE = 8192  # bytes; the list of tables is on the first page, safe from other pages' damage


def make_database(path: Path, recording: Row | None = None) -> None:
    """Make an empty project and its folder, or nothing. Raises InputError.

    `recording` has the name, relative path, absolute path and fingerprint.
    """
    if path.exists():
        raise InputError(
            "a file of this name already exists",
            where=str(path),
            remedy="Open it, or choose another name for the new project.",
        )
    _check_nothing_beside(path)
    make_folder(path.parent)
    with (
        replacing(path) as temporary,
        speaking(path),
        closing(sqlite3.connect(temporary, isolation_level=None)) as database,
    ):
        database.execute(f"PRAGMA page_size = {_PAGE_SIZE}")
        with transaction(database):
            for statement in STATEMENTS:
                database.execute(statement)
            if recording is not None:
                database.execute("INSERT INTO recording VALUES (1, ?, ?, ?, ?)", recording)
            database.execute(f"PRAGMA user_version = {FORMAT}")
            database.execute(f"PRAGMA application_id = {APPLICATION}")


def beside(path: Path) -> tuple[Path, ...]:
    """Files beside a project of an unfinished edit: a log, a journal not begun by zero."""
    sidecars = [path.with_name(path.name + suffix) for suffix in ("-journal", "-wal")]

    def begins_with_text(path: Path) -> bool:
        with path.open("rb") as file:
            return file.read(1) not in (b"", b"\0")

    return tuple(one for one in sidecars if one.is_file() and begins_with_text(one))


def leave_behind(path: Path) -> None:
    """Part from the journal of a file that was moved away; SQLite would look for the file there."""
    journal = path.with_name(f"{path.name}-journal")
    if journal.exists() and journal not in beside(path):
        journal.unlink()


def _check_nothing_beside(path: Path) -> None:
    """See that a new file of that name is not taken for one that has gone from there."""
    for left in beside(path):
        raise InputError(
            "it belongs to an earlier project of this name",
            where=str(left),
            remedy="Move it back beside that project, which needs it, or choose another name.",
        )


def check_header(path: Path) -> None:
    """See from the first bytes that this program knows the project.

    Raises InputError; ProjectDamaged where it was cut off.
    """
    if not os.path.lexists(path):
        raise InputError(
            "there is no such file",
            where=str(path),
            remedy="Correct the path. The workbench creates a project beside each recording that "
            "it opens: `stereotrack open RECORDING`.",
        )
    with open_file(path) as file:
        header = file.read(_HEADER)
    if not header:
        raise InputError("the file is empty", where=str(path), remedy="Create a new project.")
    ours = header.startswith(_MAGIC[: len(header)])
    if ours and len(header) < _HEADER:
        raise ProjectDamaged(path, f"the file ends after {len(header)} bytes")
    if not ours or struct.unpack_from(">i", header, _APPLICATION_AT) != (APPLICATION,):
        raise InputError(
            "this is not a stereotrack project",
            where=str(path),
            remedy="Open a file that ends in .stereotrack.",
        )
    check_version(path, struct.unpack_from(">i", header, _VERSION_AT)[0])


def resolved(path: Path) -> Path:
    """The file itself, to which links may lead: log and lock lie beside that."""
    try:
        return Path(path).resolve()
    except (OSError, RuntimeError, ValueError) as error:  # links in a circle, a zero in the name
        raise InputError(
            f"the link cannot be followed ({error})",
            where=str(path),
            remedy="Open the project file itself.",
        ) from error


def check_version(path: Path, version: int) -> None:
    """Refuse what another version of the program wrote in another format."""
    if not OLDEST_FORMAT <= version <= FORMAT:
        raise InputError(
            f"it has format {version}, and this program reads formats {OLDEST_FORMAT} to {FORMAT}",
            where=str(path),
            remedy="Open it with the version of the program that created it. Nothing was changed.",
        )


def version_of(database: sqlite3.Connection) -> int:
    """Format of a project."""
    version: int = database.execute("PRAGMA user_version").fetchone()[0]
    return version


def _missing(database: sqlite3.Connection) -> list[str]:
    """Statements that make what a project of an older format lacks."""
    version = version_of(database)
    later = (added for number, added in ADDED_STATEMENTS.items() if number > version)
    return [statement for added in later for statement in added]


def lend_missing(database: sqlite3.Connection) -> None:
    """Let a project of an older format that is only read look as if it had what it lacks."""
    for statement in _missing(database):
        database.execute(statement.replace("CREATE", "CREATE TEMP", 1))


def bring_up_to_date(database: sqlite3.Connection, path: Path) -> Path | None:
    """Give a project of an older format what it lacks; where its copy is, if any is made.

    The copy, ``NAME.format1.stereotrack``, is what earlier versions open. Raises InputError.
    """
    version = version_of(database)
    if version == FORMAT:
        return None
    copy = path.with_name(f"{path.stem}.format{version}{path.suffix}")
    if not copy.exists():
        copy_whole(database, copy)
    with transaction(database):
        for statement in _missing(database):
            database.execute(statement)
        database.execute(f"PRAGMA user_version = {FORMAT}")
    return copy


def copy_whole(database: sqlite3.Connection, path: Path) -> None:
    """Copy a project to another file, or nothing, and read the copy back. Raises InputError."""
    _check_nothing_beside(path)
    with replacing(path) as temporary:
        with closing(sqlite3.connect(temporary, isolation_level=None)) as target:
            database.backup(target)
            target.execute("PRAGMA journal_mode = DELETE")
            target.execute("DELETE FROM owner")
            whole = target.execute("PRAGMA quick_check(1)").fetchone()[0] == "ok"
        if not whole:
            raise InputError(
                "the copy of the project is incomplete",
                where=str(path),
                remedy="Copy it to another drive. The project itself was not changed.",
            )


def is_in_place(path: Path, identity: tuple[int, int] | None) -> bool:
    """Whether the file of this device and number, if these are known, is still in its place."""
    try:
        there = path.stat()
    except FileNotFoundError:
        return False
    return identity is None or (there.st_dev, there.st_ino) == identity


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
