"""The tables of a project file; ``click`` is written by edits, ``prediction`` by programs."""

import sqlite3
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

Value: TypeAlias = str | int | float | None
Row: TypeAlias = tuple[Value, ...]

_TYPES = {
    **dict.fromkeys(
        ("round", "frame", "visibility", "done", "used", "deleted"), "INTEGER NOT NULL"
    ),
    **dict.fromkeys(("x", "y", "sigma"), "REAL"),
    "content": "TEXT REFERENCES content (hash)",
}
"""Columns of edited tables that are not ``TEXT NOT NULL``."""


@dataclass(frozen=True)
class Table:
    """A table whose every change is kept in the history."""

    name: str
    key: tuple[str, ...]  # columns that identify a row
    values: tuple[str, ...]  # the others
    word: str = ""  # what a person calls a row

    @cached_property
    def columns(self) -> str:
        """Key and values, as they stand in a statement."""
        return ", ".join((*self.key, *self.values))

    @cached_property
    def with_key(self) -> str:
        """Condition that the row with a key satisfies."""
        return " AND ".join(f"{column} = ?" for column in self.key)

    @property
    def statement(self) -> str:
        """SQL statement that makes the table."""
        types = {name: _TYPES.get(name, "TEXT NOT NULL") for name in (*self.key, *self.values)}
        primary, numbered = f", PRIMARY KEY ({', '.join(self.key)})", self.key == ("frame",)
        if len(self.key) == 1:
            types[self.key[0]] += " PRIMARY KEY"
            primary = ""
        columns = ", ".join(f"{name} {kind}" for name, kind in types.items())
        end = "" if numbered else " WITHOUT ROWID"
        return f"CREATE TABLE {self.name} ({columns}{primary}){end}"

    def read(self, database: sqlite3.Connection, key: Row) -> Row | None:
        """Values of the row with this key, or None."""
        row: Row | None = database.execute(
            f"SELECT {', '.join(self.values)} FROM {self.name} WHERE {self.with_key}",  # noqa: S608
            key,
        ).fetchone()
        return row

    def write(self, database: sqlite3.Connection, key: Row, values: Row | None) -> None:
        """Set the row with this key; None takes it away."""
        if values is None:
            database.execute(f"DELETE FROM {self.name} WHERE {self.with_key}", key)  # noqa: S608
        else:
            row = (*key, *values)
            statement = f"INSERT OR REPLACE INTO {self.name} ({self.columns})"
            database.execute(f"{statement} VALUES ({', '.join('?' * len(row))})", row)


APPLICATION = 0x53745470  # ``application_id``, which tells what a database is for: ``StTp``
_STAMP = ("who", "at", "deleted")
_CLICK_VALUES = ("x", "y", "visibility", "flag", "sigma", "origin", *_STAMP)
_ENTRY = (("name",), ("facts", "content", *_STAMP))
CLICK = Table("click", ("frame", "camera", "landmark"), _CLICK_VALUES)
REPEAT_CLICK = Table("repeat_click", ("round", *CLICK.key), _CLICK_VALUES)
FRAME_FLAG = Table("frame_flag", ("frame", "landmark", "kind"), ("note", *_STAMP))
KEYFRAME = Table("keyframe", ("frame",), ("done", *_STAMP))
REFERENCE = Table("reference", *_ENTRY, "reference")
RUN = Table("run", *_ENTRY, "run")
SUBJECT = Table("subject", *_ENTRY, "subject")
LANDMARK_SET = Table("landmark_set", *_ENTRY, "landmark set")
PARAMETER_SET = Table("parameter_set", *_ENTRY, "preset")
DESCRIPTION = Table("description", *_ENTRY, "description")
CHOICE = Table("choice", ("name",), ("value",))
SCENARIO = Table("scenario", *_ENTRY, "scenario")
CAMERA_USE = Table("camera_use", ("camera",), ("used", *_STAMP))

FORMAT = 3  # version of the layout; kept in the file's ``user_version``
OLDEST_FORMAT = 1  # opened for writing, an older file gets what it lacks
KEYPOINT = "keypoint"  # table of what 2-D detectors have predicted
_ADD_VISIBILITY = "ALTER TABLE prediction ADD COLUMN visibility INTEGER NOT NULL DEFAULT 2"
ADDED_STATEMENTS: dict[int, tuple[str, ...]] = {
    2: (
        f"""CREATE TABLE {KEYPOINT} (
    frame INTEGER NOT NULL,
    camera TEXT NOT NULL,
    keypoint TEXT NOT NULL,
    source TEXT NOT NULL,
    person INTEGER NOT NULL,
    x REAL NOT NULL, y REAL NOT NULL,
    confidence REAL NOT NULL,
    PRIMARY KEY (frame, camera, keypoint, source, person)) WITHOUT ROWID""",
    ),
    3: (_ADD_VISIBILITY, SCENARIO.statement, CAMERA_USE.statement),
}
"""Statements that bring a project of the format before up to date."""

_SEEN_ALIKE = "CREATE TEMP VIEW prediction AS SELECT *, 2 AS visibility FROM main.prediction"


def lending(statement: str) -> str:
    """The statement that lets a file which is only read look as after one of those that are added.

    A temporary table or view goes before one of the same name in the file.
    """
    if statement == _ADD_VISIBILITY:
        return _SEEN_ALIKE
    return statement.replace("CREATE", "CREATE TEMP", 1)


_OF_ENTRIES = (REFERENCE, RUN, SUBJECT, LANDMARK_SET, PARAMETER_SET, DESCRIPTION)
TABLES_OF_ENTRIES: dict[str, Table] = {table.name: table for table in _OF_ENTRIES}
"""The tables of named things of the first format."""

EDITED_TABLES: dict[str, Table] = {
    **{table.name: table for table in (CLICK, REPEAT_CLICK, FRAME_FLAG, KEYFRAME, CHOICE)},
    **TABLES_OF_ENTRIES,
    **{table.name: table for table in (SCENARIO, CAMERA_USE)},
}
"""The tables that edits change, and nothing else does."""

STATEMENTS: tuple[str, ...] = (
    CLICK.statement,
    "CREATE INDEX click_of_landmark ON click (landmark, camera, frame)",
    "CREATE INDEX flagged_click ON click (flag, frame) WHERE flag <> ''",
    REPEAT_CLICK.statement,
    """CREATE TABLE prediction (
    frame INTEGER NOT NULL,
    camera TEXT NOT NULL,
    landmark TEXT NOT NULL,
    source TEXT NOT NULL,
    x REAL NOT NULL, y REAL NOT NULL,
    sigma REAL,
    PRIMARY KEY (frame, camera, landmark, source)) WITHOUT ROWID""",
    "CREATE INDEX prediction_of_source ON prediction (source, frame)",
    FRAME_FLAG.statement,
    KEYFRAME.statement,
    "CREATE TABLE content (hash TEXT NOT NULL PRIMARY KEY, bytes BLOB NOT NULL)",
    *(table.statement for table in TABLES_OF_ENTRIES.values()),
    CHOICE.statement,
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
    *(statement for added in ADDED_STATEMENTS.values() for statement in added),
)
"""Statements that make an empty project."""
