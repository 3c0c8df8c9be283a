"""The database of a project as a file: made, known by its first bytes, checked, copied.

A project can come from a stranger. It is plain SQLite: other tables, triggers and views do things
unasked, so a file that has any is refused before anything else of it is used.
"""

import glob
import os
import sqlite3
import struct
from collections.abc import Iterator
from contextlib import closing, contextmanager
from functools import cache
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
    lending,
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
        "Change the permissions of the file to edit the project.",
    ),
}

_TROUBLE = (sqlite3.SQLITE_CANTOPEN, sqlite3.SQLITE_IOERR, sqlite3.SQLITE_NOMEM)
"""Further result codes that no program error gives."""

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
    remedy = "Open a copy made with File, Project, Save a copy, or one from a backup of the drive."
    if kept:
        remedy = f"Open its backup with File, Open a project, or `stereotrack open {kept[-1]}`."
    return f"{remedy} This file is not changed."


class ProjectDamaged(InputError):
    """The project cannot be read; `detail` says why."""

    def __init__(self, path: Path, detail: str) -> None:
        what, remedy = f"the project file is damaged ({detail})", how_to_restore(path)
        super().__init__(what, where=str(path), remedy=remedy)


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
    except sqlite3.Error as error:
        kind = code_of(error)
        if kind in _DAMAGE or (not kind and "decode" in str(error)):
            raise ProjectDamaged(path, str(error)) from error
        if kind not in (*_SENTENCES, *_TROUBLE):
            raise
        usual = str(error), "Check the drive. All edits before the last one are saved."
        what, remedy = _SENTENCES.get(kind, usual)
        raise InputError(what, path, remedy) from error


@contextmanager
def making_sense(path: Path, *also: type[InputError]) -> Iterator[None]:
    """Take senseless values of the file for damage, and errors of these kinds; ProjectDamaged."""
    kinds: tuple[type[Exception], ...] = (*_NONSENSE, *also)
    with speaking(path):
        try:
            yield
        except kinds as error:
            said = error.what if isinstance(error, InputError) else str(error)
            raise ProjectDamaged(path, shortened(said)) from error


_MAGIC = b"SQLite format 3\0"
_HEADER = 100
_VERSION_AT, _APPLICATION_AT = 60, 68
_PAGE_SIZE = 8192  # bytes; the list of tables is on the first page, safe from other pages' damage


def make_database(path: Path, recording: Row | None = None) -> None:
    """Make an empty project and its folder, or nothing. Raises InputError.

    `recording` has the name, relative path, absolute path and fingerprint.
    """
    if path.exists():
        remedy = "Open it, or choose another name for the new project."
        raise InputError("a file of this name already exists", path, remedy)
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


def beside(path: Path) -> list[Path]:
    """Files beside a project that an unfinished edit, or a crash, has left: log or journal."""
    left = [path.with_name(path.name + suffix) for suffix in ("-journal", "-wal")]
    return [one for one in left if one.is_file() and one.stat().st_size]


def _check_nothing_beside(path: Path) -> None:
    """See that a new file of that name is not taken for one that has gone from there."""
    for left in beside(path):
        remedy = "Move it back beside that project, which needs it, or choose another name."
        raise InputError("it belongs to an earlier project of this name", left, remedy)


def check_header(path: Path) -> None:
    """See by its first bytes that it is a known project. Raises InputError, ProjectDamaged."""
    if not os.path.lexists(path):
        raise InputError(
            "there is no such file",
            path,
            "Correct the path. The workbench creates a project beside each recording that "
            "it opens: `stereotrack open RECORDING`.",
        )
    with open_file(path) as file:
        header = file.read(_HEADER)
    if not header:
        raise InputError("the file is empty", path, "Create a new project.")
    ours = header.startswith(_MAGIC[: len(header)])
    if ours and len(header) < _HEADER:
        raise ProjectDamaged(path, f"the file ends after {len(header)} bytes")
    if not ours or struct.unpack_from(">i", header, _APPLICATION_AT) != (APPLICATION,):
        what = "this is not a stereotrack project"
        raise InputError(what, path, "Open a file that ends in .stereotrack.")
    check_version(path, struct.unpack_from(">i", header, _VERSION_AT)[0])


def check_version(path: Path, version: int) -> None:
    """Refuse what another version of the program wrote in another format."""
    if not OLDEST_FORMAT <= version <= FORMAT:
        raise InputError(
            f"it has format {version}, and this program reads formats {OLDEST_FORMAT} to {FORMAT}",
            path,
            "Open it with the version of the program that created it. Nothing was changed.",
        )


def version_of(database: sqlite3.Connection) -> int:
    """Format of a project."""
    return int(database.execute("PRAGMA user_version").fetchone()[0])


def _missing(database: sqlite3.Connection) -> list[str]:
    """Statements that make what a project of an older format lacks."""
    version = version_of(database)
    later = (added for number, added in ADDED_STATEMENTS.items() if number > version)
    return [statement for added in later for statement in added]


def lend_missing(database: sqlite3.Connection) -> None:
    """Let a project of an older format that is only read look as if it had what it lacks."""
    for statement in _missing(database):
        database.execute(lending(statement))


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
        check_schema(database, path)  # what was written; where it is wrong, nothing is
        check_whole(database, path)
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
            remedy = "Copy it to another drive. The project itself was not changed."
            raise InputError("the copy of the project is incomplete", path, remedy)


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


def _objects(database: sqlite3.Connection) -> frozenset[tuple[str, ...]]:
    """Kind, name, table and statement (without spaces) of all that a database consists of."""
    rows = database.execute("SELECT type, name, tbl_name, ifnull(sql, '') FROM sqlite_schema")
    return frozenset((*names, "".join(str(sql).split()).lower()) for *names, sql in rows)


@cache
def _expected(version: int) -> frozenset[tuple[str, ...]]:
    """The same of an empty project of a format."""
    later = {s for number, added in ADDED_STATEMENTS.items() if number > version for s in added}
    with closing(sqlite3.connect(":memory:")) as database:
        for statement in STATEMENTS:
            if statement not in later:
                database.execute(statement)
        return _objects(database)


def check_schema(database: sqlite3.Connection, path: Path) -> None:
    """See that there are a project's tables and no others. Raises InputError, ProjectDamaged."""
    expected, found = _expected(version_of(database)), _objects(database)
    for kind, name, *_ in sorted(found - expected):
        raise InputError(
            f"it was modified by another program: the {kind} {shortened(repr(name))} is not as "
            "this program creates it",
            path,
            f"It could be harmful, so nothing of it is used. {how_to_restore(path)}",
        )
    for kind, name, *_ in sorted(expected - found):
        if kind == "table":  # an index that earlier versions did not make may be missing
            raise ProjectDamaged(path, f"the table {name} is missing")


def check_whole(database: sqlite3.Connection, path: Path) -> None:
    """See that the pages of the file are whole. Raises ProjectDamaged."""
    verdict = str(database.execute("PRAGMA integrity_check(1)").fetchone()[0])
    if verdict != "ok":
        raise ProjectDamaged(path, verdict.splitlines()[-1])
