"""What SQLite complains about, in words for the person whose project it is."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from stereotrack_core.errors import InputError, shortened

PRIMARY = 0xFF
"""The part of SQLite's result codes that names the kind of failure."""

_SENTENCES: dict[int, tuple[str, str]] = {
    sqlite3.SQLITE_BUSY: (
        "another program is reading or writing it",
        "Close the project there or wait, then repeat the last edit; it was not made.",
    ),
    sqlite3.SQLITE_FULL: (
        "there is no space left on the drive",
        "Free space and repeat the last edit. All earlier edits are saved.",
    ),
    sqlite3.SQLITE_READONLY: (
        "it is write-protected",
        "Change the permissions of the file, or open it read-only.",
    ),
    sqlite3.SQLITE_CANTOPEN: (
        "it cannot be opened",
        "Check that the drive is connected and that you may read the file.",
    ),
    sqlite3.SQLITE_IOERR: (
        "the drive reports an error",
        "Check the drive. All edits before the last one are saved.",
    ),
    sqlite3.SQLITE_NOMEM: (
        "there is not enough memory",
        "Close other programs. All edits before the last one are saved.",
    ),
}

_CONTRADICTIONS: dict[int, str] = {
    sqlite3.SQLITE_CORRUPT: "",
    sqlite3.SQLITE_NOTADB: "",
    sqlite3.SQLITE_CONSTRAINT: "",
    sqlite3.SQLITE_MISMATCH: "",
    sqlite3.SQLITE_TOOBIG: "",
    sqlite3.SQLITE_ERROR: "",
    sqlite3.SQLITE_INTERRUPT: "reading it does not finish",
}
"""What only comes of a file that is not as it should be; in which words, if not in SQLite's."""

NONSENSE = (ValueError, TypeError, LookupError, OverflowError, RecursionError)
"""What comes of making something of values that nothing can be made of."""

RESCUE = (
    "The workbench can recover what is readable into a new file (File, Project, Recover damaged "
    "project). This file is not changed."
)


class ProjectDamaged(InputError):
    """The file is a project, but parts of it cannot be read.

    :func:`stereotrack_core.project.rescue.rescue` saves what can be read to another file.

    Parameters
    ----------
    detail : str
        What is wrong, in a few words.
    first : str, optional
        What to do before anything is rescued, as a sentence.
    """

    def __init__(self, path: Path, detail: str, first: str = "") -> None:
        self.detail = detail
        super().__init__(
            f"the project file is damaged ({detail})",
            where=str(path),
            remedy=f"{first or 'Use another copy of it.'} {RESCUE}",
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
    except sqlite3.Error as error:
        kind = code_of(error)
        if kind in _CONTRADICTIONS or (not kind and "decode" in str(error)):
            raise ProjectDamaged(path, _CONTRADICTIONS.get(kind) or str(error)) from error
        if kind not in _SENTENCES:
            raise
        what, remedy = _SENTENCES[kind]
        raise InputError(what, where=str(path), remedy=remedy) from error


@contextmanager
def making_sense(path: Path) -> Iterator[None]:
    """Take values that nothing can be made of for what they are: damage.

    Raises
    ------
    ProjectDamaged
        For whatever the block meets in the file's values.
    """
    with speaking(path):
        try:
            yield
        except NONSENSE as error:
            said = shortened(str(error))
            what = f"{said} is missing" if isinstance(error, KeyError) else said
            raise ProjectDamaged(path, what) from error
