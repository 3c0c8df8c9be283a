"""What SQLite complains about, in words for the person whose project it is."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from stereotrack_core.errors import InputError

PRIMARY = 0xFF
"""The part of SQLite's result codes that names the kind of failure."""

_SENTENCES: dict[int, tuple[str, str]] = {
    sqlite3.SQLITE_BUSY: (
        "another program is reading or writing it",
        "Close the project there, or wait until that is done; the last edit was not made.",
    ),
    sqlite3.SQLITE_FULL: (
        "there is no space left on the drive",
        "Make space and do the last edit again; everything before it is saved.",
    ),
    sqlite3.SQLITE_READONLY: (
        "it may not be written to",
        "Give yourself the right to write it, or open it for reading only.",
    ),
    sqlite3.SQLITE_CANTOPEN: (
        "it cannot be opened",
        "Look whether the drive is there and whether you may read the file.",
    ),
    sqlite3.SQLITE_IOERR: (
        "the drive reports a failure",
        "Look whether the drive is there; everything before the last edit is saved.",
    ),
}


class ProjectDamaged(InputError):
    """The file is a project, but parts of it cannot be read.

    :func:`stereotrack_core.project.rescue.rescue` saves what can be read to another file.

    Parameters
    ----------
    path : Path
    detail : str
        What is wrong, in a few words.
    first : str, optional
        What to do before anything is rescued, as a sentence.
    """

    def __init__(self, path: Path, detail: str, first: str = "") -> None:
        super().__init__(
            f"the project file is damaged ({detail})",
            where=str(path),
            remedy=f"{first or 'Take another copy of it.'} Or let the workbench rescue what can be"
            " read into a new file (File, Project); this one is left as it is.",
        )


class ProjectInUse(InputError):
    """Another program has the project open for writing; it can still be read."""


def code_of(error: sqlite3.Error) -> int:
    """SQLite's primary result code; 0 where Python itself complains."""
    return getattr(error, "sqlite_errorcode", 0) & PRIMARY


@contextmanager
def speaking(path: Path) -> Iterator[None]:
    """Turn failures of the database within the block into sentences about `path`.

    Raises
    ------
    ProjectDamaged
        Where the file contradicts itself.
    InputError
        For everything else that the drive or another program is the reason of.
    """
    try:
        yield
    except UnicodeDecodeError as error:  # in a message about a list of tables that is rubbish
        raise ProjectDamaged(path, "its list of tables cannot be read") from error
    except sqlite3.DatabaseError as error:
        kind = code_of(error)
        if kind in (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB) or _is_rubbish(kind, error):
            raise ProjectDamaged(path, str(error)) from error
        if kind not in _SENTENCES:
            raise
        what, remedy = _SENTENCES[kind]
        raise InputError(what, where=str(path), remedy=remedy) from error


def _is_rubbish(kind: int, error: sqlite3.DatabaseError) -> bool:
    """Whether a text is no UTF-8, or a table or column that every project has is missing."""
    said = str(error)
    if not kind:
        return "decode" in said
    return kind == sqlite3.SQLITE_ERROR and ("no such" in said or "has no column" in said)
