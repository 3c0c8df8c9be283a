"""Mend a database that has lost its list of tables with the list of a new project.

Tables are made in one order, so a project that was never migrated has them on the same pages as a
new one. Offsets are those of SQLite's file format (https://www.sqlite.org/fileformat2.html).
"""

from __future__ import annotations

import struct
from pathlib import Path

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
