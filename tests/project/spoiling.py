"""Damaged and hostile projects, made from a whole one: what drives, tools and strangers may do."""

from __future__ import annotations

import random
import shutil
import sqlite3
from collections.abc import Callable
from contextlib import closing, suppress
from pathlib import Path

PAGE = 8192
DEEP = "[" * 3000 + "]" * 3000
ENDLESS = "9" * 400

VALUES: tuple[object, ...] = (
    *(None, b"", b"\x00\xff\xfe", bytes(5000), "", "\0", "a\0b", "\x1b[31mred\x1b[0m", "x" * 5000),
    *("../" * 50, "a" * 300 + "/b", "NaN", "five", "1; DROP TABLE click", "\u202egnp", "\n"),
    *(-1, 0, 1, 2, 3, 2**31, 2**53 + 1, 2**62, -(2**63), 0.5, -0.5, 1e18, 1e308, 9e999, -9e999),
)
JSON_TEXTS = (
    *(
        "[]",
        "{}",
        "null",
        "5",
        '"text"',
        "[1, 2",
        "{",
        "NaN",
        "[NaN]",
        "[Infinity]",
        DEEP,
        "\ufeff{}",
    ),
    *(ENDLESS, f"[{ENDLESS}]", f'{{"frames": {ENDLESS}}}', '{"frames": "many"}', '{"frames": [1]}'),
    *('{"preset": 5, "values": [1]}', '{"values": {}}', f'{{"hip_width": {ENDLESS}}}'),
    *('{"hip_width": NaN}', '{"hip_width": "wide"}', '{"hip_width": {"a": 1}}'),
    *('{"name": 5, "landmarks": 5}', '{"name": "a", "landmarks": [[], 5, null]}'),
    *('{"changed": {"a": 5}}', '{"versions": [5]}', '{"asked": [1]}', '{"asked": {"a": 1}}'),
    *('{"first": "x", "views": 5}', '{"views": [[1], null]}', '{"wall_seconds": "long"}'),
    *('{"reason": 1, "time_offsets": [1], "first_frames": {}, "stream_cameras": {}}',),
    *('[1, "N_left", "head"]', '["x", null, [1]]', "[1.5, 2.5, 2]", '[9e999, 1, 2, "", null]'),
    *(f'{{"a": {DEEP}}}', f"[{DEEP}]"),
)
JSON_COLUMNS = ("facts", "value", "before", "after", "changed_key")

SCHEMA: tuple[str, ...] = (
    "CREATE TRIGGER t AFTER INSERT ON click BEGIN DELETE FROM click WHERE frame % 7 <> 3; END",
    "CREATE TRIGGER t AFTER INSERT ON owner BEGIN DELETE FROM click; END",
    "CREATE TRIGGER t AFTER DELETE ON owner BEGIN INSERT INTO annotator WITH RECURSIVE r(i)"
    " AS (SELECT 1 UNION ALL SELECT i + 1 FROM r) SELECT 'a' || i, '' FROM r; END",
    "DROP TABLE click; CREATE VIEW click AS WITH RECURSIVE r(i) AS (SELECT 1 UNION ALL SELECT i + 1"
    " FROM r) SELECT i AS frame, 'N_left' AS camera, 'head' AS landmark, 1.5 AS x, 2.5 AS y,"
    " 2 AS visibility, '' AS flag, NULL AS sigma, 'hand' AS origin, 'A' AS who, '' AS at,"
    " 0 AS deleted FROM r",
    "DROP TABLE recording; CREATE VIEW recording AS WITH RECURSIVE r(i) AS (SELECT 1 UNION ALL"
    " SELECT i + 1 FROM r) SELECT max(i) AS only, '' AS name, '' AS relative, '' AS absolute,"
    " '' AS fingerprint FROM r",
    "DROP TABLE owner; CREATE VIEW owner AS WITH RECURSIVE r(i) AS (SELECT 1 UNION ALL SELECT i + 1"
    " FROM r) SELECT max(i) AS only, '' AS host, 1 AS process, '' AS who, '' AS at FROM r",
    "DROP TABLE keyframe; CREATE TABLE keyframe (frame INTEGER NOT NULL PRIMARY KEY,"
    " done INTEGER NOT NULL, who TEXT NOT NULL, at TEXT NOT NULL,"
    " deleted INTEGER GENERATED ALWAYS AS (length(hex(zeroblob(400000000)))) VIRTUAL)",
    "DROP TABLE choice; CREATE TABLE choice (name TEXT NOT NULL PRIMARY KEY, value TEXT NOT NULL,"
    " CHECK (length(hex(zeroblob(400000000))) > 0)) WITHOUT ROWID",
    "DROP TABLE choice; CREATE TABLE choice (name TEXT NOT NULL PRIMARY KEY, value TEXT NOT NULL"
    " DEFAULT (hex(randomblob(100000000)))) WITHOUT ROWID",
    "DROP TABLE prediction; CREATE VIRTUAL TABLE prediction USING fts5(frame, camera, landmark,"
    " source, x, y, sigma)",
    "CREATE VIRTUAL TABLE more USING rtree(id, a, b)",
    "CREATE INDEX more ON click (frame) WHERE length(hex(zeroblob(1000000))) > 5",
    "CREATE TABLE more (a)",
    "ALTER TABLE click ADD COLUMN more TEXT",
    "ALTER TABLE click RENAME COLUMN x TO z",
    "ALTER TABLE edit_change RENAME TO edit_changes",
    "DROP TABLE edit",
    "DROP TABLE owner",
    "DROP TABLE content",
    "DROP INDEX click_of_landmark",
    "ANALYZE",
    "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET rootpage = 2 WHERE name = 'keyframe'",
    "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET rootpage = 99999 WHERE name = 'edit'",
    "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET rootpage = -1 WHERE name = 'edit'",
    "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET sql = 'rubbish' WHERE name = 'click'",
    "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET sql = x'ff00' WHERE name = 'click'",
    "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET name = CAST(x'ff' AS TEXT)"
    " WHERE name = 'choice'",
    "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET tbl_name = 'edit' WHERE name = 'choice'",
    "PRAGMA writable_schema = ON; DELETE FROM sqlite_schema WHERE name LIKE 'sqlite_auto%'",
    "PRAGMA writable_schema = ON; DELETE FROM sqlite_schema",
    "PRAGMA journal_mode = WAL",
    "PRAGMA user_version = 0",
    "PRAGMA user_version = -5",
    "PRAGMA user_version = 1",
    "PRAGMA user_version = 2147483647",
)
"""What somebody may do to a project with a tool for databases."""

HEADER = ((16, 2), (18, 1), (19, 1), (20, 1), (21, 3), (24, 4), (28, 4), (32, 4), (36, 4), (40, 4))
HEADER += ((44, 4), (52, 4), (56, 4), (60, 4), (64, 4), (92, 4))
"""Fields of the file's first hundred bytes: place and length."""


def page(path: Path, choose: random.Random) -> None:
    """A page of rubbish."""
    content = bytearray(path.read_bytes())
    first = PAGE * choose.randrange(len(content) // PAGE)
    content[first : first + PAGE] = choose.randbytes(PAGE)
    path.write_bytes(content)


def pages(path: Path, choose: random.Random) -> None:
    """Pages in each other's places."""
    content = bytearray(path.read_bytes())
    count = len(content) // PAGE
    for _ in range(choose.choice([1, 2, 10])):
        one, other = (PAGE * choose.randrange(count) for _ in range(2))
        content[one : one + PAGE] = content[other : other + PAGE]
    path.write_bytes(content)


def some_bytes(path: Path, choose: random.Random) -> None:
    """Wrong bytes."""
    content = bytearray(path.read_bytes())
    for _ in range(choose.choice([1, 20, 400])):
        content[choose.randrange(len(content))] = choose.randrange(256)
    path.write_bytes(content)


def bits(path: Path, choose: random.Random) -> None:
    """Bits turned over where something is stored."""
    content = bytearray(path.read_bytes())
    used = [place for place, value in enumerate(content) if value]
    for place in choose.sample(used, choose.choice([1, 3, 30])):
        content[place] ^= 1 << choose.randrange(8)
    path.write_bytes(content)


def letters(path: Path, choose: random.Random) -> None:
    """Wrong letters in texts."""
    content = bytearray(path.read_bytes())
    for place in choose.choices(range(len(content)), k=30):
        if content[place] >= ord(" "):
            content[place] = choose.choice(b'0123456789abc"[]{},\xff')
    path.write_bytes(content)


def end(path: Path, choose: random.Random) -> None:
    """An end that comes too soon, or too late."""
    content = path.read_bytes()
    more = choose.randbytes(choose.randrange(1, 9000))
    path.write_bytes(
        content[: choose.randrange(len(content))] if choose.random() < 0.7 else content + more
    )


def header(path: Path, choose: random.Random) -> None:
    """A field of the header that says something else."""
    content = bytearray(path.read_bytes())
    place, length = choose.choice(HEADER)
    number = choose.choice(
        [0, 1, 2, 3, 5, 255, 2**15, 2**31 - 1, 2**32 - 5, choose.getrandbits(32)]
    )
    content[place : place + length] = (number % 256**length).to_bytes(length, "big")
    path.write_bytes(content)


def schema(path: Path, choose: random.Random) -> None:
    """Other tables, triggers and views."""
    with closing(sqlite3.connect(path)) as database:
        for statement in choose.sample(SCHEMA, choose.choice([1, 1, 1, 2])):
            with suppress(sqlite3.Error):
                database.executescript(statement)


def values(path: Path, choose: random.Random) -> None:
    """Values of another kind in some columns."""
    with closing(sqlite3.connect(path)) as database:
        database.execute("PRAGMA ignore_check_constraints = ON")
        for _ in range(choose.choice([1, 1, 5])):
            put_anything(database, choose)
        database.commit()


def put_anything(database: sqlite3.Connection, choose: random.Random) -> None:
    """Put a value of any kind into one column of one row, or of all rows."""
    tables = [
        name for (name,) in database.execute("SELECT name FROM sqlite_schema WHERE type='table'")
    ]
    table = choose.choice(sorted(tables))
    column = choose.choice([row[1] for row in database.execute(f"PRAGMA table_info({table})")])
    texts = JSON_TEXTS if column in JSON_COLUMNS and choose.random() < 0.8 else VALUES
    mark = "CAST(? AS TEXT)" if choose.random() < 0.1 else "?"
    value = choose.choice(texts)
    there = [one for (one,) in database.execute(f"SELECT {column} FROM {table} LIMIT 50")]
    update = f"UPDATE OR IGNORE {table} SET {column} = {mark}"
    with suppress(sqlite3.Error):
        if choose.random() < 0.3 or not there:
            database.execute(update, (value,))
        else:
            database.execute(f"{update} WHERE {column} IS ?", (value, choose.choice(there)))


def beside(path: Path, choose: random.Random) -> None:
    """Something beside it that is not of it."""
    suffix = choose.choice(["-journal", "-wal", "-shm"])
    other = path.with_name(path.name + suffix)
    content = path.read_bytes()
    first = choose.choice([b"\xd9\xd5\x05\xf9\x20\xa1\x63\xd7", b"\x37\x7f\x06\x82", b""])
    other.write_bytes(first + choose.choice([content[:PAGE], choose.randbytes(9000), bytes(600)]))
    if suffix != "-journal" and choose.random() < 0.7:
        spoilt = bytearray(content)
        spoilt[18:20] = b"\2\2"
        path.write_bytes(spoilt)


def twice(path: Path, choose: random.Random) -> None:
    """Two kinds of damage."""
    for kind in choose.sample([page, some_bytes, bits, header, schema, values], 2):
        kind(path, choose)


KINDS: tuple[Callable[[Path, random.Random], None], ...] = (
    *(page, pages, some_bytes, bits, letters, end, header, beside, twice),
    *(schema, schema, values, values, values, values),
)


def spoil(whole: Path, path: Path, seed: int) -> str:
    """Make a damaged copy; the kind of damage."""
    choose = random.Random(seed)
    shutil.copyfile(whole, path)
    kind = choose.choice(KINDS)
    with suppress(sqlite3.Error, UnicodeDecodeError):  # what is damaged once may be unreadable
        kind(path, choose)
    return kind.__name__
