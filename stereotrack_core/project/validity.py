"""Whether a project is one that this program writes: its tables, and every value in them.

A project can come from a stranger. What is not exactly as the program makes it is refused before
anything else of it is used: triggers and views do things unasked, and a value of another kind would
come up as a failure somewhere else.
"""

from __future__ import annotations

import re
import sqlite3
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from stereotrack_core.errors import InputError, shortened
from stereotrack_core.project.database import RESCUE, ProjectDamaged, making_sense, version_of
from stereotrack_core.project.edit import change_of, facts_of
from stereotrack_core.project.schema import (
    ADDED_STATEMENTS,
    CLICK,
    EDITED_TABLES,
    FORMAT,
    REPEAT_CLICK,
    STATEMENTS,
    TABLES_OF_ENTRIES,
    Row,
    Table,
)

_TOKEN = re.compile(r"""'(?:[^']|'')*'|"(?:[^"]|"")*"|\w+|\S""")
_FARTHEST_FRAME = 100_000_000
_LARGEST = 2**53
LARGEST_REAL = 1e9
"""Far beyond every image, and below what drawing cannot deal with."""

_BY_KIND = {
    "INTEGER": f"typeof({{0}}) = 'integer' AND {{0}} BETWEEN 0 AND {_LARGEST}",
    "REAL": f"typeof({{0}}) = 'real' AND abs({{0}}) <= {LARGEST_REAL}",
    "TEXT": "typeof({0}) = 'text' AND instr({0}, char(0)) = 0",
    "BLOB": "typeof({0}) = 'blob'",
}
"""What a value has to be like, by the declared type of its column."""

_BY_NAME = {
    "frame": f"frame <= {_FARTHEST_FRAME}",
    "visibility": "visibility <= 2",
    "deleted": "deleted <= 1",
    "done": "done <= 1",
    "sigma": "sigma >= 0",
    "confidence": "confidence BETWEEN 0 AND 1",
    "state": "state IN ('done', 'undone', 'dropped')",
    "changed_table": f"changed_table IN ({', '.join(map(repr, EDITED_TABLES))})",
}
_OF_CLICKS = (
    "(x IS NULL) = (y IS NULL) AND (x IS NULL) = (visibility = 0) AND (sigma IS NULL OR sigma > 0)"
)


@dataclass(frozen=True)
class Made:
    """Something in the list of tables: what the program has made, or is found there."""

    kind: str
    name: str
    table: str
    statement: str | None

    def same(self, other: Made) -> bool:
        """Whether both say the same, however it is spaced."""
        return (self.kind, self.table, _tokens(self.statement)) == (
            other.kind,
            other.table,
            _tokens(other.statement),
        )


def _tokens(statement: str | None) -> list[str]:
    words = _TOKEN.findall(statement or "")
    return [word if word[0] in "'\"" else word.lower() for word in words]


@cache
def made(version: int = FORMAT) -> Mapping[str, Made]:
    """What a new project of a format has, by name."""
    later = {s for number, added in ADDED_STATEMENTS.items() if number > version for s in added}
    with closing(_new(later)) as database:
        return {one.name: one for one in _found(database)}


def _new(without: Collection[str] = ()) -> sqlite3.Connection:
    database = sqlite3.connect(":memory:")
    for statement in STATEMENTS:
        if statement not in without:
            database.execute(statement)
    return database


def _found(database: sqlite3.Connection) -> Iterable[Made]:
    rows = database.execute("SELECT type, name, tbl_name, sql FROM sqlite_schema").fetchall()
    return [Made(*row) for row in rows]


def check_schema(database: sqlite3.Connection, path: Path) -> None:
    """See that there is nothing but the tables and indexes of a project.

    Raises InputError where there is something else; ProjectDamaged where a table is missing.
    """
    wanted, seen = made(version_of(database)), set()
    for found in _found(database):
        seen.add(found.name)
        if found.name not in wanted or not found.same(wanted[found.name]):
            raise InputError(
                f"it was modified by another program: the {found.kind} "
                f"{shortened(repr(found.name))} is not as this program creates it",
                where=str(path),
                remedy=f"It could be harmful, so nothing of the project is used. {RESCUE}",
            )
    missing = [one.name for one in wanted.values() if one.kind == "table" and one.name not in seen]
    if missing:
        raise ProjectDamaged(path, f"the table {missing[0]} is missing")


@cache
def sense() -> Mapping[str, str]:
    """Condition that every row of a table satisfies, by the table's name."""
    with closing(_new()) as database:
        return {
            one.name: _condition(one.name, database.execute(f"PRAGMA table_info({one.name})"))
            for one in made().values()
            if one.kind == "table" and not one.name.startswith("sqlite_")
        }


def _condition(table: str, columns: Iterable[tuple[Any, ...]]) -> str:
    conditions = [_OF_CLICKS] if table in (CLICK.name, REPEAT_CLICK.name) else []
    for _, name, kind, needed, _, in_key in columns:
        said = [_BY_KIND[kind].format(name), *([_BY_NAME[name]] if name in _BY_NAME else [])]
        condition = " AND ".join(said)
        conditions.append(condition if needed or in_key else f"({name} IS NULL OR {condition})")
    return f"({' AND '.join(conditions)}) IS TRUE"


def check_rows(
    database: sqlite3.Connection, path: Path, tables: Iterable[str] | None = None
) -> None:
    """See that every value is one that the program can have written.

    `tables`: names of the tables; all without it.

    Raises ProjectDamaged where there is a row that makes no sense.
    """
    there = made(version_of(database))
    for name in (n for n in sense() if n in there) if tables is None else tables:
        row = database.execute(
            f"SELECT * FROM {name} WHERE NOT {sense()[name]} LIMIT 1"  # noqa: S608 - constants
        ).fetchone()
        if row is not None:
            raise ProjectDamaged(path, f"invalid row of {name}: {shortened(repr(row))}")
        if name in TABLES_OF_ENTRIES:
            with making_sense(path):
                for (facts,) in database.execute(f"SELECT facts FROM {name}"):  # noqa: S608
                    facts_of(facts)


def makes_sense(database: sqlite3.Connection, table: Table, key: Row) -> bool:
    """Whether the row with this key, where there is one, is as all rows of its table are."""
    condition = f"{sense()[table.name]} FROM {table.name} WHERE {table.with_key}"
    row = database.execute(f"SELECT {condition}", key).fetchone()
    return row is None or bool(row[0])


def check_whole(database: sqlite3.Connection, path: Path) -> None:
    """See that a file is whole that was not closed, or was copied while it was open.

    A copy that was made in the middle of an edit has some pages of before and some of after. Pages
    that do not fit together are found by SQLite; edits of which it has a part, by their history.

    Raises ProjectDamaged where something is missing.
    """
    database.execute("BEGIN")
    try:
        verdict = str(database.execute("PRAGMA integrity_check(1)").fetchone()[0]).splitlines()[-1]
        wrong = "" if verdict == "ok" else verdict
        wrong = wrong or contradiction(database)
    finally:
        database.execute("ROLLBACK")
    if wrong:
        raise ProjectDamaged(
            path,
            f"{wrong}, as in a copy made during an edit",
            "Copy it again from the source, with the file of the same name that ends in -journal "
            "if there is one. If such a file belongs to a different copy, move it away.",
        )


def contradiction(database: sqlite3.Connection) -> str:
    """What a table and the history say differently, in words; empty where they agree."""
    numbers = {row[0] for row in database.execute("SELECT number FROM edit")}
    changed = {row[0] for row in database.execute("SELECT DISTINCT edit FROM edit_change")}
    if numbers != changed or (numbers and numbers != set(range(1, max(numbers) + 1))):
        return "its history has gaps"
    words = last_words(database)
    for (name, key), after in words.items():
        if EDITED_TABLES[name].read(database, key) != after:
            return f"the history of {name} is inconsistent with its rows"
    for table in EDITED_TABLES.values():
        if any((table.name, key) not in words for key in _keys_since_first_edit(database, table)):
            return f"the history of {table.name} is incomplete"
    return ""


def _keys_since_first_edit(database: sqlite3.Connection, table: Table) -> Iterator[Row]:
    """Keys of rows that an edit must have written; a rescued project may have older ones."""
    if "at" in table.values:
        yield from database.execute(
            f"SELECT {', '.join(table.key)} FROM {table.name}"  # noqa: S608 - constants
            " WHERE at >= (SELECT at FROM edit ORDER BY number LIMIT 1)"
        )


def last_words(database: sqlite3.Connection) -> dict[tuple[str, Row], Row | None]:
    """Row after the last edit in effect, by table and key.

    Raises ValueError, LookupError where the history keeps something else.
    """
    changes = database.execute(
        "SELECT changed_table, changed_key, after FROM edit_change JOIN edit ON number = edit"
        " WHERE state = 'done' ORDER BY edit, place"
    )
    found = (
        change_of(EDITED_TABLES[name], key, None, after) for name, key, after in changes.fetchall()
    )
    return {(change.table.name, change.key): change.after for change in found}
