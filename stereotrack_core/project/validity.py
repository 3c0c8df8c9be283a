"""Whether a file is a whole project as this program writes it.

A project can come from a stranger. It is plain SQLite: other tables, triggers and views do things
unasked, so a file that has any is refused before anything else of it is used.
"""

import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import closing
from functools import cache
from pathlib import Path

from stereotrack_core.errors import InputError, shortened
from stereotrack_core.project.database import ProjectDamaged, how_to_restore, version_of
from stereotrack_core.project.edit import change_of
from stereotrack_core.project.schema import (
    ADDED_STATEMENTS,
    EDITED_TABLES,
    FORMAT,
    RUN,
    STATEMENTS,
    Row,
    Table,
)

LARGEST_REAL = 1e9  # far beyond every image, and below what drawing cannot deal with
_CONDITIONS = {
    "INTEGER": "typeof({0}) = 'integer' AND {0} BETWEEN 0 AND 9007199254740992",
    "REAL": f"typeof({{0}}) = 'real' AND abs({{0}}) <= {LARGEST_REAL}",
    "TEXT": "typeof({0}) = 'text' AND instr({0}, char(0)) = 0",
    "BLOB": "typeof({0}) = 'blob'",
}
"""Condition on a value, by the declared type of its column."""

_FRAME = "typeof(frame) = 'integer' AND frame BETWEEN 0 AND 100000000"
"""Arrays are made with one row for each frame up to the last one."""


def _new_project(version: int) -> sqlite3.Connection:
    """An empty project of a format, in memory."""
    later = {s for number, added in ADDED_STATEMENTS.items() if number > version for s in added}
    database = sqlite3.connect(":memory:")
    for statement in STATEMENTS:
        if statement not in later:
            database.execute(statement)
    return database


def _objects(database: sqlite3.Connection) -> frozenset[tuple[str, ...]]:
    """Kind, name, table and statement (without spaces) of all that a database consists of."""
    rows = database.execute("SELECT type, name, tbl_name, ifnull(sql, '') FROM sqlite_schema")
    return frozenset((*names, "".join(str(sql).split()).lower()) for *names, sql in rows)


@cache
def _expected(version: int) -> frozenset[tuple[str, ...]]:
    with closing(_new_project(version)) as database:
        return _objects(database)


def check_schema(database: sqlite3.Connection, path: Path) -> None:
    """See that there are a project's tables and no others. Raises InputError, ProjectDamaged."""
    expected, found = _expected(version_of(database)), _objects(database)
    for kind, name, *_ in sorted(found - expected):
        raise InputError(
            f"it was modified by another program: the {kind} {shortened(repr(name))} is not as "
            "this program creates it",
            where=str(path),
            remedy=f"It could be harmful, so nothing of it is used. {how_to_restore(path)}",
        )
    for kind, name, *_ in sorted(expected - found):
        if kind == "table":  # an index that earlier versions did not make may be missing
            raise ProjectDamaged(path, f"the table {name} is missing")


@cache
def conditions() -> Mapping[str, str]:
    """Condition that every row of a table satisfies, by the table's name."""
    with closing(_new_project(FORMAT)) as database:
        tables = [name for kind, name, *_ in _objects(database) if kind == "table"]
        return {
            name: " AND ".join(_conditions_of(database, name))
            for name in sorted(tables)
            if not name.startswith("sqlite_")
        }


def _conditions_of(database: sqlite3.Connection, table: str) -> Iterator[str]:
    for _, name, kind, needed, _, in_key in database.execute(f"PRAGMA table_info({table})"):
        condition = _FRAME if name == "frame" else _CONDITIONS[kind].format(name)
        yield f"({condition})" if needed or in_key else f"({name} IS NULL OR {condition})"


def makes_sense(database: sqlite3.Connection, table: Table, key: Row) -> bool:
    """Whether the row with this key, if there is one, is as all rows of its table are."""
    condition = f"({conditions()[table.name]}) FROM {table.name} WHERE {table.with_key}"
    row = database.execute(f"SELECT {condition}", key).fetchone()
    return row is None or bool(row[0])


def check_whole(database: sqlite3.Connection, path: Path, *, closed: bool) -> None:
    """See that the file is whole: its pages, its values and, if it was not closed, its history.

    A copy made in the middle of an edit has pages of before and of after. Raises ProjectDamaged.
    """
    database.execute("BEGIN")  # one state, also while another program writes
    try:
        verdict = str(database.execute("PRAGMA integrity_check(1)").fetchone()[0]).splitlines()[-1]
        wrong = verdict if verdict != "ok" else _invalid_row(database)
        if not (wrong or closed):
            wrong = contradiction(database)
    finally:
        database.execute("ROLLBACK")
    if wrong and closed:
        raise ProjectDamaged(path, wrong)
    if wrong:
        raise ProjectDamaged(
            path,
            f"{wrong}, as in a copy made during an edit",
            "Copy it again from the source, with the file of the same name that ends in -journal "
            "if there is one. If such a file belongs to a different copy, move it away.",
        )


def _invalid_row(database: sqlite3.Connection) -> str:
    """The first row whose values are not of their kind, in words; empty if there is none."""
    tables = {name for kind, name, *_ in _expected(version_of(database)) if kind == "table"}
    for name, condition in conditions().items():
        if name in tables:
            row = database.execute(
                f"SELECT * FROM {name} WHERE ({condition}) IS NOT TRUE LIMIT 1"  # noqa: S608
            ).fetchone()
            if row is not None:
                return f"invalid row of {name}: {shortened(repr(row))}"
    return ""


def contradiction(database: sqlite3.Connection) -> str:
    """Contradiction between a table, not of runs, and the history, in words; or empty."""
    numbers = {row[0] for row in database.execute("SELECT number FROM edit")}
    changed = {row[0] for row in database.execute("SELECT DISTINCT edit FROM edit_change")}
    if numbers != changed or (numbers and numbers != set(range(1, max(numbers) + 1))):
        return "its history has gaps"
    latest = _latest_rows(database)
    for (name, key), after in latest.items():
        if name != RUN.name and EDITED_TABLES[name].read(database, key) != after:
            return f"the history of {name} is inconsistent with its rows"
    for table in EDITED_TABLES.values():
        if any((table.name, key) not in latest for key in _keys_since_first_edit(database, table)):
            return f"the history of {table.name} is incomplete"
    return ""


def _keys_since_first_edit(database: sqlite3.Connection, table: Table) -> Iterator[Row]:
    """Keys of rows that an edit must have written; a project may have older rows without one."""
    if "at" in table.values and table is not RUN:
        yield from database.execute(
            f"SELECT {', '.join(table.key)} FROM {table.name}"  # noqa: S608 - constants
            " WHERE at >= (SELECT at FROM edit ORDER BY number LIMIT 1)"
        )


def _latest_rows(database: sqlite3.Connection) -> dict[tuple[str, Row], Row | None]:
    """Row after the last edit in effect, by table and key. Raises ValueError, LookupError."""
    changes = database.execute(
        "SELECT changed_table, changed_key, after FROM edit_change JOIN edit ON number = edit"
        " WHERE state = 'done' ORDER BY edit, place"
    )
    found = (
        change_of(EDITED_TABLES[name], key, None, after) for name, key, after in changes.fetchall()
    )
    return {(change.table.name, change.key): change.after for change in found}
