"""The tables of a project file.

What people do and what programs compute stand in different tables: ``click`` is written by edits
alone, ``prediction`` by programs alone.
"""

from __future__ import annotations

import sqlite3
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

Value: TypeAlias = str | int | float | None
Row: TypeAlias = tuple[Value, ...]


@dataclass(frozen=True)
class Table:
    """A table whose every change is kept in the history.

    Attributes
    ----------
    name : str
    key : tuple of str
        Columns that identify a row.
    values : tuple of str
        The others.
    """

    name: str
    key: tuple[str, ...]
    values: tuple[str, ...]

    @cached_property
    def columns(self) -> str:
        """Key and values, as they stand in a statement."""
        return ", ".join((*self.key, *self.values))

    @cached_property
    def _with_key(self) -> str:
        return " AND ".join(f"{column} = ?" for column in self.key)

    @cached_property
    def _select(self) -> str:
        values = ", ".join(self.values)
        return f"SELECT {values} FROM {self.name} WHERE {self._with_key}"  # noqa: S608 - no input

    @cached_property
    def _replace(self) -> str:
        marks = ", ".join("?" * (len(self.key) + len(self.values)))
        return f"INSERT OR REPLACE INTO {self.name} ({self.columns}) VALUES ({marks})"  # noqa: S608

    @cached_property
    def _delete(self) -> str:
        return f"DELETE FROM {self.name} WHERE {self._with_key}"  # noqa: S608 - no input

    def read(self, database: sqlite3.Connection, key: Row) -> Row | None:
        """Values of the row with this key, or None."""
        row: Row | None = database.execute(self._select, key).fetchone()
        return row

    def write(self, database: sqlite3.Connection, key: Row, values: Row | None) -> None:
        """Set the row with this key; None takes it away."""
        if values is None:
            database.execute(self._delete, key)
        else:
            database.execute(self._replace, (*key, *values))


FORMAT = 1
"""Version of the layout; kept in the file's ``user_version``."""

APPLICATION = 0x53745470
"""Kept in the file's ``application_id``, which tells what a database is for: ``StTp``."""

_CLICK_VALUES = (
    *("x", "y", "visibility", "flag", "sigma"),
    *("origin", "who", "at", "deleted"),
)
_ENTRY_VALUES = ("facts", "content", "who", "at", "deleted")

CLICK = Table("click", ("frame", "camera", "landmark"), _CLICK_VALUES)
REPEAT_CLICK = Table("repeat_click", ("round", "frame", "camera", "landmark"), _CLICK_VALUES)
FRAME_FLAG = Table("frame_flag", ("frame", "landmark", "kind"), ("note", "who", "at", "deleted"))
KEYFRAME = Table("keyframe", ("frame",), ("done", "who", "at", "deleted"))
REFERENCE = Table("reference", ("name",), _ENTRY_VALUES)
RUN = Table("run", ("name",), _ENTRY_VALUES)
SUBJECT = Table("subject", ("name",), _ENTRY_VALUES)
LANDMARK_SET = Table("landmark_set", ("name",), _ENTRY_VALUES)
PARAMETER_SET = Table("parameter_set", ("name",), _ENTRY_VALUES)
DESCRIPTION = Table("description", ("name",), _ENTRY_VALUES)
CHOICE = Table("choice", ("name",), ("value",))

TABLES_OF_ENTRIES: dict[str, Table] = {
    table.name: table
    for table in (REFERENCE, RUN, SUBJECT, LANDMARK_SET, PARAMETER_SET, DESCRIPTION)
}
"""The tables of named things."""

EDITED_TABLES: dict[str, Table] = {
    **{table.name: table for table in (CLICK, REPEAT_CLICK, FRAME_FLAG, KEYFRAME, CHOICE)},
    **TABLES_OF_ENTRIES,
}
"""The tables that edits change, and nothing else does."""

_CLICK_COLUMNS = """
    frame INTEGER NOT NULL,
    camera TEXT NOT NULL,
    landmark TEXT NOT NULL,
    x REAL, y REAL,
    visibility INTEGER NOT NULL,
    flag TEXT NOT NULL,
    sigma REAL,
    origin TEXT NOT NULL,
    who TEXT NOT NULL,
    at TEXT NOT NULL,
    deleted INTEGER NOT NULL"""

_ENTRY_COLUMNS = """
    name TEXT NOT NULL PRIMARY KEY,
    facts TEXT NOT NULL,
    content TEXT REFERENCES content (hash),
    who TEXT NOT NULL,
    at TEXT NOT NULL,
    deleted INTEGER NOT NULL"""


def _entries(name: str) -> str:
    return f"CREATE TABLE {name} ({_ENTRY_COLUMNS}) WITHOUT ROWID"


STATEMENTS: tuple[str, ...] = (
    f"CREATE TABLE click ({_CLICK_COLUMNS}, PRIMARY KEY (frame, camera, landmark)) WITHOUT ROWID",
    "CREATE INDEX click_of_landmark ON click (landmark, camera, frame)",
    "CREATE INDEX flagged_click ON click (flag, frame) WHERE flag <> ''",
    f"CREATE TABLE repeat_click (round INTEGER NOT NULL, {_CLICK_COLUMNS},"
    " PRIMARY KEY (round, frame, camera, landmark)) WITHOUT ROWID",
    """CREATE TABLE prediction (
    frame INTEGER NOT NULL,
    camera TEXT NOT NULL,
    landmark TEXT NOT NULL,
    source TEXT NOT NULL,
    x REAL NOT NULL, y REAL NOT NULL,
    sigma REAL,
    PRIMARY KEY (frame, camera, landmark, source)) WITHOUT ROWID""",
    "CREATE INDEX prediction_of_source ON prediction (source, frame)",
    """CREATE TABLE frame_flag (
    frame INTEGER NOT NULL,
    landmark TEXT NOT NULL,
    kind TEXT NOT NULL,
    note TEXT NOT NULL,
    who TEXT NOT NULL,
    at TEXT NOT NULL,
    deleted INTEGER NOT NULL,
    PRIMARY KEY (frame, landmark, kind)) WITHOUT ROWID""",
    """CREATE TABLE keyframe (
    frame INTEGER NOT NULL PRIMARY KEY,
    done INTEGER NOT NULL,
    who TEXT NOT NULL,
    at TEXT NOT NULL,
    deleted INTEGER NOT NULL)""",
    "CREATE TABLE content (hash TEXT NOT NULL PRIMARY KEY, bytes BLOB NOT NULL)",
    *(_entries(name) for name in TABLES_OF_ENTRIES),
    "CREATE TABLE choice (name TEXT NOT NULL PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID",
    """CREATE TABLE edit (
    number INTEGER PRIMARY KEY AUTOINCREMENT,
    kind TEXT NOT NULL,
    words TEXT NOT NULL,
    who TEXT NOT NULL,
    at TEXT NOT NULL,
    state TEXT NOT NULL)""",
    "CREATE INDEX edit_in_state ON edit (state, number)",
    """CREATE TABLE edit_change (
    edit INTEGER NOT NULL REFERENCES edit (number),
    place INTEGER NOT NULL,
    changed_table TEXT NOT NULL,
    changed_key TEXT NOT NULL,
    before TEXT,
    after TEXT,
    PRIMARY KEY (edit, place)) WITHOUT ROWID""",
    "CREATE TABLE annotator (name TEXT NOT NULL PRIMARY KEY, first_at TEXT NOT NULL) WITHOUT ROWID",
    "CREATE TABLE view_setting (name TEXT NOT NULL PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID",
    """CREATE TABLE recording (
    only INTEGER NOT NULL PRIMARY KEY CHECK (only = 1),
    name TEXT NOT NULL,
    relative TEXT NOT NULL,
    absolute TEXT NOT NULL,
    fingerprint TEXT NOT NULL)""",
    """CREATE TABLE owner (
    only INTEGER NOT NULL PRIMARY KEY CHECK (only = 1),
    host TEXT NOT NULL,
    process INTEGER NOT NULL,
    who TEXT NOT NULL,
    at TEXT NOT NULL)""",
)
"""What makes an empty project."""
