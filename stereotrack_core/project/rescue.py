"""Save what can be read of a damaged project into a new file."""

from __future__ import annotations

import errno
import sqlite3
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from stereotrack_core.atomic import replacing
from stereotrack_core.errors import InputError
from stereotrack_core.project.connection import connect_to_rescue
from stereotrack_core.project.database import (
    NONSENSE,
    check_files,
    check_free,
    copy_files,
    make_tables,
    speaking,
    transaction,
)
from stereotrack_core.project.edit import change_of, facts_of
from stereotrack_core.project.entries import hash_of
from stereotrack_core.project.schema import EDITED_TABLES, FORMAT, KEYPOINT, TABLES_OF_ENTRIES
from stereotrack_core.project.validity import contradiction, last_words, made, makes_sense, sense

_OTHER_TABLES = ("content", "prediction", KEYPOINT, "annotator", "view_setting", "recording")
_FULL = (errno.ENOSPC, errno.EFBIG, errno.EDQUOT)
_HISTORY = ("edit", "edit_change")


@dataclass(frozen=True)
class Rescued:
    """What was saved into a new project: number of rows by table.

    Rows of people's work that were damaged in their table may stand in the history; without a whole
    history the new project begins with none.
    """

    path: Path
    rows: Mapping[str, int]
    from_history: int
    history_whole: bool


def rescue(damaged: Path, target: Path) -> Rescued:
    """Read row by row, from both ends of every table, past what is damaged; then the history.

    The damaged file is not touched. The history only comes along where it agrees with the rows:
    undo has to be right or absent.

    InputError where nothing can be read, or the target exists or cannot be written.
    """
    with tempfile.TemporaryDirectory() as folder:
        check_files(damaged)
        try:
            copy = copy_files(damaged, Path(folder))
        except OSError as error:
            full = error.errno in _FULL
            raise InputError(
                f"it cannot be {'copied' if full else 'read'} ({error.strerror})",
                where=str(damaged),
                remedy=f"Free space in {folder}." if full else "Correct the path.",
            ) from error
        check_free(target)
        _use_own_tables(copy)
        with speaking(target), replacing(target) as temporary:
            saved = _fill(copy, temporary)
            if not any(saved.rows.values()):
                raise InputError(
                    f"nothing in it can be read as a project of format {FORMAT}",
                    where=str(damaged),
                    remedy="Use a copy made with File, Project, or a backup of the drive.",
                )
    return replace(saved, path=target)


def _fill(copy: Path, target: Path) -> Rescued:
    """Make a project of an empty file, with what can be read."""
    with (
        closing(connect_to_rescue(copy)) as source,
        closing(sqlite3.connect(target, isolation_level=None)) as database,
    ):
        make_tables(database)
        return _filled(source, database, target)


def _filled(source: sqlite3.Connection, database: sqlite3.Connection, target: Path) -> Rescued:
    with transaction(database):
        tables = (*_OTHER_TABLES, *_HISTORY, *EDITED_TABLES)
        counts = {table: _copy(source, database, table) for table in tables}
        _drop_wrong_content(database)
        restored = _restore_from_history(database)
        whole = _history_agrees(database)
        if not whole:
            for table in reversed(_HISTORY):
                database.execute(f"DELETE FROM {table}")  # noqa: S608 - constants
    return Rescued(target, counts, restored, whole)


def _use_own_tables(copy: Path) -> None:
    """Let the list of tables say what that of a new project says, wherever the tables are.

    So nothing is left of what somebody else has put there, and a letter that has changed in a
    statement does not matter. Where the list cannot be read, nothing happens.
    """
    with suppress(sqlite3.Error), closing(connect_to_rescue(copy)) as database:
        database.text_factory = lambda text: text.decode(errors="replace")
        found = database.execute("SELECT name, rootpage FROM sqlite_schema").fetchall()
        with transaction(database):
            database.execute("DELETE FROM sqlite_schema")
            database.executemany(
                "INSERT INTO sqlite_schema VALUES (?, ?, ?, ?, ?)",
                (
                    (one.kind, one.name, one.table, page, one.statement)
                    for name, page in found
                    if (one := made().get(name))
                ),
            )


def _copy(source: sqlite3.Connection, target: sqlite3.Connection, table: str) -> int:
    """Copy what can be read of a table; the number of rows."""
    info = target.execute(f"PRAGMA table_info({table})").fetchall()
    columns = [row[1] for row in info]
    key = [row[1] for row in sorted(info, key=lambda row: row[5]) if row[5]]
    insert = (
        f"INSERT OR IGNORE INTO {table} ({', '.join(columns)})"  # noqa: S608 - constants
        f" VALUES ({', '.join('?' * len(columns))})"
    )
    for direction in ("ASC", "DESC"):
        order = ", ".join(f"{column} {direction}" for column in key)
        select = f"SELECT {', '.join(columns)} FROM {table} ORDER BY {order}"  # noqa: S608
        for row in _readable(source, select):
            try:
                _make_sense_of(table, row)
                target.execute(insert, row)
            except (*NONSENSE, sqlite3.IntegrityError, sqlite3.InterfaceError):
                continue  # a row of rubbish
    target.execute(f"DELETE FROM {table} WHERE NOT {sense()[table]}")  # noqa: S608 - constants
    count: int = target.execute(f"SELECT count(*) FROM {table}").fetchone()[0]  # noqa: S608
    return count


def _make_sense_of(table: str, row: Sequence[Any]) -> None:
    """Raise ValueError or the like for a row whose JSON nothing can be made of."""
    if table == "edit_change":
        _, _, changed, key, before, after = row
        change_of(EDITED_TABLES[changed], key, before, after)
    elif table in TABLES_OF_ENTRIES:
        facts_of(row[1])


def _readable(source: sqlite3.Connection, select: str) -> Iterator[tuple[Any, ...]]:
    """Rows up to where the file is damaged."""
    try:
        yield from source.execute(select)
    except (sqlite3.Error, UnicodeDecodeError):
        return


def _drop_wrong_content(database: sqlite3.Connection) -> None:
    """Forget runs and references whose data are not what they were."""
    for name, data in database.execute("SELECT hash, bytes FROM content").fetchall():
        if not isinstance(data, bytes) or hash_of(data) != name:
            database.execute("DELETE FROM content WHERE hash = ?", (name,))
    for table in EDITED_TABLES.values():
        if "content" in table.values:
            database.execute(
                f"DELETE FROM {table.name} WHERE content IS NOT NULL"  # noqa: S608 - constants
                " AND content NOT IN (SELECT hash FROM content)"
            )


def _restore_from_history(database: sqlite3.Connection) -> int:
    """Set rows that the history's last word knows better than their table; their number."""
    restored = 0
    for (table_name, key), after in last_words(database).items():
        table = EDITED_TABLES[table_name]
        try:
            if table.read(database, key) is None and after is not None:
                _make_sense_of(table_name, (*key, *after))
                table.write(database, key, after)
                if makes_sense(database, table, key):
                    restored += 1
                else:
                    table.write(database, key, None)
        except (*NONSENSE, sqlite3.IntegrityError, sqlite3.ProgrammingError):
            continue
    return restored


def _history_agrees(database: sqlite3.Connection) -> bool:
    """Whether every edit is there, and the rows are exactly those that the history leads to."""
    try:
        if contradiction(database):
            return False
    except (*NONSENSE, sqlite3.ProgrammingError):
        return False
    expected: dict[str, int] = dict.fromkeys(EDITED_TABLES, 0)
    for (table, _), after in last_words(database).items():
        expected[table] += after is not None
    return all(
        database.execute(f"SELECT count(*) FROM {table}").fetchone()[0] == count  # noqa: S608
        for table, count in expected.items()
    )
