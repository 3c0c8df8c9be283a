"""Write the project of format 1 that the migration is tested on: ``data/format-1.stereotrack``.

The file is part of the tests; this script says how it was made. Format 1 had no origins, no sigma
and no deleted rows of clicks, no second readings and no predictions.
"""

from __future__ import annotations

import json
import sqlite3
import sys
from pathlib import Path

TARGET = Path(__file__).with_name("data") / "format-1.stereotrack"
APPLICATION = 0x53745470
AT = "2026-01-05T10:00:00.000+00:00"

_ENTRY = """(name TEXT NOT NULL PRIMARY KEY, facts TEXT NOT NULL,
    content TEXT REFERENCES content (hash), who TEXT NOT NULL, at TEXT NOT NULL,
    deleted INTEGER NOT NULL) WITHOUT ROWID"""
_NAMED = ("reference", "run", "subject", "landmark_set", "parameter_set", "description")

STATEMENTS = (
    """CREATE TABLE click (frame INTEGER NOT NULL, camera TEXT NOT NULL, landmark TEXT NOT NULL,
    x REAL, y REAL, visibility INTEGER NOT NULL, flag TEXT NOT NULL, who TEXT NOT NULL,
    at TEXT NOT NULL, PRIMARY KEY (frame, camera, landmark)) WITHOUT ROWID""",
    """CREATE TABLE frame_flag (frame INTEGER NOT NULL, landmark TEXT NOT NULL, kind TEXT NOT NULL,
    note TEXT NOT NULL, who TEXT NOT NULL, at TEXT NOT NULL, deleted INTEGER NOT NULL,
    PRIMARY KEY (frame, landmark, kind)) WITHOUT ROWID""",
    """CREATE TABLE keyframe (frame INTEGER NOT NULL PRIMARY KEY, done INTEGER NOT NULL,
    who TEXT NOT NULL, at TEXT NOT NULL, deleted INTEGER NOT NULL)""",
    "CREATE TABLE content (hash TEXT NOT NULL PRIMARY KEY, bytes BLOB NOT NULL)",
    *(f"CREATE TABLE {name} {_ENTRY}" for name in _NAMED),
    "CREATE TABLE choice (name TEXT NOT NULL PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID",
    """CREATE TABLE edit (number INTEGER PRIMARY KEY AUTOINCREMENT, kind TEXT NOT NULL,
    words TEXT NOT NULL, who TEXT NOT NULL, at TEXT NOT NULL, state TEXT NOT NULL)""",
    "CREATE INDEX edit_in_state ON edit (state, number)",
    """CREATE TABLE edit_change (edit INTEGER NOT NULL REFERENCES edit (number),
    place INTEGER NOT NULL, changed_table TEXT NOT NULL, changed_key TEXT NOT NULL,
    before TEXT, after TEXT, PRIMARY KEY (edit, place)) WITHOUT ROWID""",
    "CREATE TABLE annotator (name TEXT NOT NULL PRIMARY KEY, first_at TEXT NOT NULL) WITHOUT ROWID",
    "CREATE TABLE view_setting (name TEXT NOT NULL PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID",
    """CREATE TABLE recording (only INTEGER NOT NULL PRIMARY KEY CHECK (only = 1),
    name TEXT NOT NULL, relative TEXT NOT NULL, absolute TEXT NOT NULL,
    fingerprint TEXT NOT NULL)""",
    """CREATE TABLE owner (only INTEGER NOT NULL PRIMARY KEY CHECK (only = 1),
    host TEXT NOT NULL, process INTEGER NOT NULL, who TEXT NOT NULL, at TEXT NOT NULL)""",
)

CLICKS = {
    (0, "N_right", "left_elbow"): (10.5, 20.25, 2, "", "A", AT),
    (0, "N_right", "right_elbow"): (30.0, 21.0, 1, "uncertain", "A", AT),
    (0, "S_cam", "left_elbow"): (None, None, 0, "", "B", AT),
}
MOVED = (11.5, 20.25, 2, "", "A", AT)


def write(path: Path) -> None:
    """Three edits: one click and two at once, then the first one moved, and that undone."""
    path.unlink(missing_ok=True)
    database = sqlite3.connect(path)
    database.execute("PRAGMA page_size = 1024")
    for statement in STATEMENTS:
        database.execute(statement)
    first = next(iter(CLICKS))
    for key, values in CLICKS.items():
        database.execute(f"INSERT INTO click VALUES ({','.join('?' * 9)})", (*key, *values))
    history = (
        ("place left elbow in N_right, frame 0", "done", [(first, None, CLICKS[first])]),
        (
            "place 2 landmarks in 2 cameras, frame 0",
            "done",
            [(key, None, values) for key, values in CLICKS.items() if key != first],
        ),
        ("move left elbow in N_right, frame 0", "undone", [(first, CLICKS[first], MOVED)]),
    )
    for number, (words, state, changes) in enumerate(history, start=1):
        database.execute(
            "INSERT INTO edit VALUES (?, 'place clicks', ?, 'A', ?, ?)", (number, words, AT, state)
        )
        for place, (key, before, after) in enumerate(changes):
            texts = [None if row is None else json.dumps(row) for row in (key, before, after)]
            database.execute(
                "INSERT INTO edit_change VALUES (?, ?, 'click', ?, ?, ?)", (number, place, *texts)
            )
    database.execute("INSERT INTO keyframe VALUES (0, 1, 'A', ?, 0)", (AT,))
    database.execute("INSERT INTO annotator VALUES ('A', ?)", (AT,))
    database.execute("INSERT INTO view_setting VALUES ('frame', '17')")
    database.execute(
        "INSERT INTO recording VALUES (1, 'walk', 'walk', '/data/walk', ?)", ("0" * 32,)
    )
    database.execute("PRAGMA user_version = 1")
    database.execute(f"PRAGMA application_id = {APPLICATION}")
    database.commit()
    database.execute("VACUUM")
    database.close()


if __name__ == "__main__":
    write(Path(sys.argv[1]) if len(sys.argv) > 1 else TARGET)
