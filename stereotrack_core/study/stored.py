"""A study with the file that it was read from: edits never overwrite what others have written."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError
from stereotrack_core.reading import TABLE_BYTES, open_file
from stereotrack_core.study.file import Study, bytes_of, check_name, read_study, write_study

FACTORS = ("subject", "condition", "repetition")
"""Columns that a new study has; they can be renamed and removed."""


class StudyChanged(InputError):
    """The file is no longer what was read: another program has changed, moved or deleted it."""


@dataclass(frozen=True)
class StoredStudy:
    """A study as its file has it."""

    study: Study
    digest: str
    """Of the bytes of the file."""

    @staticmethod
    def read(path: Path) -> StoredStudy:
        """Read a study file. Raises InputError as :func:`read_study`."""
        check_name(path)
        digest = _digest_of(path)  # before it is read: what changes in between is noticed
        return StoredStudy(read_study(path), digest)

    @staticmethod
    def new(path: Path, factors: Sequence[str] = FACTORS) -> StoredStudy:
        """Write a study without recordings.

        Raises InputError where the name is not one of a study, something of that name is there, or
        it cannot be written.
        """
        check_name(path)
        if path.exists():
            raise InputError(
                "there is a study of this name already",
                where=str(path),
                remedy="Open it, or choose another name.",
            )
        write_study(Study(path, tuple(factors)))
        return StoredStudy.read(path)

    @property
    def is_current(self) -> bool:
        """Whether the file still has what was read."""
        return _digest_of(self.study.path) == self.digest

    def saved(self, study: Study) -> StoredStudy:
        """Write another state of this study, and give it with its file.

        A write that fails leaves the old file. Raises StudyChanged where the file is not the one
        that was read, and InputError where it cannot be written.
        """
        path, data = self.study.path, bytes_of(study)

        def look() -> None:
            found = _digest_of(path)
            if found != self.digest:
                raise _changed(path, missing=not found)

        write_file(path, data, look)
        return StoredStudy(study, hashlib.blake2b(data).hexdigest())


def _digest_of(path: Path) -> str:
    """Empty where the file cannot be read."""
    try:
        with open_file(path, TABLE_BYTES) as file:
            return hashlib.blake2b(file.read()).hexdigest()
    except (InputError, OSError):
        return ""


def _changed(path: Path, *, missing: bool) -> StudyChanged:
    if missing:
        return StudyChanged(
            "the study file is no longer there or cannot be read, so nothing was written",
            where=str(path),
            remedy="Move it back, or open it where it is now.",
        )
    return StudyChanged(
        "another program has changed the study file, so nothing was overwritten",
        where=str(path),
        remedy="Refresh reads what is there now; then make the edit again.",
    )
