"""Whether a project's file is whole: its pages, and its rows beside the history that made them."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from pathlib import Path

from stereotrack_core.project.failures import ProjectDamaged
from stereotrack_core.project.rows import Row, Table, change_of
from stereotrack_core.project.schema import EDITED_TABLES


def check_whole(database: sqlite3.Connection, path: Path) -> None:
    """See that a file is whole that was not closed, or was copied while it was open.

    A copy that was made in the middle of an edit has some pages of before and some of after. Pages
    that do not fit together are found by SQLite; edits of which it has a part, by their history.

    Raises
    ------
    ProjectDamaged
        Where something is missing.
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
            f"{wrong}, as in a copy that was made in the middle of an edit",
            "Copy it again where it comes from, with the file of the same name that ends in"
            " -journal if there is one; if that lies beside it but is of another copy, move it"
            " away.",
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
            return f"the history of {name} contradicts its rows"
    for table in EDITED_TABLES.values():
        if any((table.name, key) not in words for key in _keys_since_first_edit(database, table)):
            return f"the history of {table.name} lacks rows"
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

    Raises
    ------
    ValueError, LookupError
        Where the history keeps something else.
    """
    changes = database.execute(
        "SELECT changed_table, changed_key, after FROM edit_change JOIN edit ON number = edit"
        " WHERE state = 'done' ORDER BY edit, place"
    )
    found = (
        change_of(EDITED_TABLES[name], key, None, after) for name, key, after in changes.fetchall()
    )
    return {(change.table.name, change.key): change.after for change in found}
