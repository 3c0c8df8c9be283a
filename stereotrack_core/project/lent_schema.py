"""Mend a database that has lost its list of tables with the list of a new project.

Tables are made in one order, so a project that was never migrated has them on the same pages as a
new one. Offsets are those of SQLite's file format (https://www.sqlite.org/fileformat2.html).
"""

from __future__ import annotations

import sqlite3
import struct
from contextlib import closing, suppress
from pathlib import Path

from stereotrack_core.project.connection import connect_to_rescue
from stereotrack_core.project.database import transaction, version_of
from stereotrack_core.project.schema import FORMAT, STATEMENTS_OF
from stereotrack_core.project.validity import made

_HEADER = 100
_PAGE_SIZE_AT, _CHANGES_AT, _PAGES_AT, _VALID_FOR_AT = 16, 24, 28, 92
_FIRST_TREE_AT = 100
_INTERIOR = 5
_PAGE_SIZES = (512, 1024, 2048, 4096, 8192, 16384, 32768)
_USUAL_SIZE = 4096


def lend_schema(new: Path, damaged: Path) -> None:
    """Overwrite the header and the list of tables of `damaged` with those of `new`.

    Parameters
    ----------
    new : Path
        A project that has just been made.
    damaged : Path
        A copy that may be spoilt further; a log beside it is taken away.
    """
    source = new.read_bytes()
    (size,) = struct.unpack_from(">H", source, _PAGE_SIZE_AT)
    content = bytearray(damaged.read_bytes())
    del content[len(content) // size * size :]
    if len(content) < len(source):
        return
    for page in _schema_pages(source):
        content[page * size : (page + 1) * size] = source[page * size : (page + 1) * size]
    damaged.write_bytes(content)
    count_pages(damaged)
    for suffix in ("-wal", "-shm", "-journal"):
        damaged.with_name(damaged.name + suffix).unlink(missing_ok=True)


def own_tables(damaged: Path) -> None:
    """Let the list of tables say what that of a new project says, wherever the tables are.

    So nothing is left of what somebody else has put there, and a letter that has changed in a
    statement does not matter. Where the list cannot be read, nothing happens.

    Parameters
    ----------
    damaged : Path
        A copy that may be spoilt further.
    """
    with (
        suppress(sqlite3.Error),
        closing(connect_to_rescue(damaged)) as database,
    ):
        database.text_factory = lambda text: text.decode(errors="replace")
        database.execute("PRAGMA writable_schema = ON")
        wanted = made(known if (known := version_of(database)) in STATEMENTS_OF else FORMAT)
        found = database.execute("SELECT name, rootpage FROM sqlite_schema").fetchall()
        with transaction(database):
            database.execute("DELETE FROM sqlite_schema")
            for name, page in found:
                if one := wanted.get(name):
                    database.execute(
                        "INSERT INTO sqlite_schema VALUES (?, ?, ?, ?, ?)",
                        (one.kind, one.name, one.table, page, one.statement),
                    )


def count_pages(damaged: Path) -> None:
    """Let the header count the pages that are there.

    Half a page at the end, which SQLite would fill up with zeros, is taken away; pages that came
    after the header was copied are counted, since older pages may refer to them.
    """
    length = damaged.stat().st_size
    with damaged.open("r+b") as file:
        header = bytearray(file.read(_HEADER))
        if len(header) < _HEADER:
            return
        (size,) = struct.unpack_from(">H", header, _PAGE_SIZE_AT)
        if size not in _PAGE_SIZES:
            size = _USUAL_SIZE
        file.truncate(length // size * size)
        struct.pack_into(">I", header, _PAGES_AT, length // size)
        header[_VALID_FOR_AT : _VALID_FOR_AT + 4] = header[_CHANGES_AT : _CHANGES_AT + 4]
        file.seek(0)
        file.write(header)


def _schema_pages(source: bytes) -> list[int]:
    """Pages of the list of tables from 0: the first one, and those that it points to."""
    kind, count = source[_FIRST_TREE_AT], *struct.unpack_from(">H", source, _FIRST_TREE_AT + 3)
    if kind != _INTERIOR:
        return [0]
    (last,) = struct.unpack_from(">I", source, _FIRST_TREE_AT + 8)
    cells = struct.unpack_from(f">{count}H", source, _FIRST_TREE_AT + 12)
    children = [struct.unpack_from(">I", source, cell)[0] for cell in cells]
    return [0, *(page - 1 for page in [*children, last])]
