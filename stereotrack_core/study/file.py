"""The study file: a table of recordings and projects that a spreadsheet can edit.

Its columns ``recording``, ``project`` and ``fingerprint`` are the program's, all others are
factors: the subject, the condition, the repetition, or whatever a person adds.
"""

from __future__ import annotations

import codecs
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from pathlib import Path, PurePosixPath

from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError, did_you_mean
from stereotrack_core.reading import TABLE_BYTES, open_file
from stereotrack_core.tables import csv_text, read_csv_table

SUFFIX = ".study.csv"

_FIRST_BYTES = 65536

OWN_COLUMNS = ("recording", "project", "fingerprint")
"""Columns that are no factors."""

RESULT_COLUMNS = (
    *("run", "kept_in", "preset", "changes", "seed", "reference", "up_to_date"),
    *("measure", "statistic", "unit", "value"),
)
"""What a table of results says of every value; no factor may be called so."""


@dataclass(frozen=True)
class StudyRow:
    """A recording of a study."""

    recording: str
    """Folder, relative to the study file, with ``/``; absolute on another drive."""
    project: str = ""
    """The same of the project; empty where there is none."""
    fingerprint: str = ""
    """By which the recording is found again; empty where it is not known yet."""
    factors: Mapping[str, str] = field(default_factory=dict)
    """What a person says about it, by column."""


@dataclass(frozen=True)
class Study:
    """What a study file says."""

    path: Path
    factors: tuple[str, ...] = ()
    """Names of the further columns, in their order."""
    rows: tuple[StudyRow, ...] = ()
    delimiter: str = ","
    """Between cells; a spreadsheet of some countries writes semicolons."""
    order: tuple[str, ...] = ()
    """All columns as the file has them; empty where the program's own come first."""
    marked: bool = False
    """Whether the file begins with the byte order mark by which some spreadsheets know UTF-8."""

    @property
    def columns(self) -> tuple[str, ...]:
        """All columns in the order in which they are written."""
        known = (*OWN_COLUMNS, *self.factors)
        placed = tuple(name for name in self.order if name in known)
        return (*placed, *(name for name in known if name not in placed))

    @property
    def folder(self) -> Path:
        """Folder that paths are relative to."""
        return self.path.absolute().parent

    @property
    def stem(self) -> str:
        """Name of the file without its suffixes."""
        return self.path.name.removesuffix(SUFFIX)

    @property
    def runs(self) -> Path:
        """Folder of the study's own runs."""
        return self.folder / f"{self.stem}.runs"

    @property
    def cache(self) -> Path:
        """What is known of its files, so that they need not be read again."""
        return self.folder / f"{self.stem}.study-cache.json"

    def place(self, relative: str) -> Path:
        """The file or folder that a cell names."""
        return Path(os.path.normpath(self.folder / relative))

    def relative(self, path: Path) -> str:
        """How a cell names a file or folder."""
        path = path.absolute()
        try:
            return Path(os.path.relpath(path, self.folder)).as_posix()
        except ValueError:  # another drive of Windows
            return path.as_posix()

    def runs_of(self, row: StudyRow) -> Path:
        """Folder of the study's own runs of a recording; where it is listed, not where it is."""
        parts = PurePosixPath(row.recording).parts
        named = ["up" if part == ".." else part for part in parts if part != "."]
        anchored = PurePosixPath(row.recording).is_absolute()
        return self.runs.joinpath(*(named[1:] if anchored else named))


def check_name(path: Path) -> None:
    """Refuse a name that no study file has. Raises InputError with one that would do."""
    if not path.name.endswith(SUFFIX) or path.name == SUFFIX:
        stem = path.name.split(".")[0] or "walks"
        raise InputError(
            f"the name of a study must end in {SUFFIX}",
            where=str(path),
            remedy=f"Use the name {stem}{SUFFIX}.",
        )


def read_study(path: Path) -> Study:
    """Read a study file; the folders that it names are not looked at.

    Raises InputError where it cannot be read, a recording is missing in a row or listed twice, or
    a column has a name that results need.
    """
    check_name(path)
    delimiter, marked = _signs_of(path)
    columns, cells = read_csv_table(path, delimiter)
    if "recording" not in columns:
        raise InputError(
            "the column 'recording' is missing in the first line",
            where=str(path),
            remedy="Make the file with `stereotrack study create`, or write one row per recording "
            "with commas between the values.",
        )
    taken = [name for name in columns if name in RESULT_COLUMNS]
    if taken:
        raise InputError(
            f"a column is called {taken[0]!r}, which is a column of the results",
            where=str(path),
            remedy="Give it another name.",
        )
    factors = tuple(name for name in columns if name not in OWN_COLUMNS)
    rows = []
    for row in cells:
        named = dict(zip(columns, row, strict=True))
        own = {name: named.get(name, "") for name in OWN_COLUMNS}
        rows.append(StudyRow(**own, factors={name: named[name] for name in factors}))
    study = Study(path, factors, tuple(rows), delimiter, columns, marked)
    study = replace(study, order=_order_of(study))
    _check_rows(study)
    return study


def _order_of(study: Study) -> tuple[str, ...]:
    """The columns as they are written; none where that is the usual order."""
    usual = (*OWN_COLUMNS, *study.factors)
    return () if study.columns == usual else study.columns


def _signs_of(path: Path) -> tuple[str, bool]:
    """The sign beside a column of ours in the first line, and whether a byte order mark is there.

    The sign is a comma or a semicolon.
    """
    with open_file(path, TABLE_BYTES) as file:
        first = file.readline(_FIRST_BYTES)
    semicolons = re.search(rb'recording"?;|;"?recording', first)
    return ";" if semicolons else ",", first.startswith(codecs.BOM_UTF8)


def _check_rows(study: Study) -> None:
    seen: set[Path] = set()
    for number, row in enumerate(study.rows, start=1):
        place = study.place(row.recording)
        if not row.recording or place in seen:
            raise InputError(
                f"the recording {row.recording!r} is listed twice"
                if row.recording
                else f"recording number {number} has no folder",
                where=str(study.path),
                remedy="Delete one of the rows." if row.recording else "Write it, or delete it.",
            )
        seen.add(place)


def write_study(study: Study) -> None:
    """Write a study file; a write that fails leaves the old one.

    Raises InputError where it cannot be written.
    """
    write_file(study.path, bytes_of(study))


def bytes_of(study: Study) -> bytes:
    """What a study file holds."""
    columns = study.columns
    rows = [[cell_of(row, name) for name in columns] for row in study.rows]
    mark = codecs.BOM_UTF8 if study.marked else b""
    return mark + csv_text(columns, rows, study.delimiter).encode()


def selected(study: Study, select: Sequence[str]) -> tuple[StudyRow, ...]:
    """Rows that agree with all of ``COLUMN=VALUE``, in their order.

    Several values are separated by commas, ``*`` stands for any letters. Raises InputError for a
    column that the study does not have, or where no row is left.
    """
    rows = study.rows
    for text in select:
        name, sign, values = (part.strip() for part in text.partition("="))
        known = (*OWN_COLUMNS, *study.factors)
        if not sign or name not in known:
            raise InputError(
                f"the study has no column {name!r}" if sign else f"{text!r} cannot be read",
                where="--select",
                remedy=f"{did_you_mean(name, known)}Write COLUMN=VALUE; the columns are: "
                f"{', '.join(known)}.",
            )
        patterns = [value.strip() for value in values.split(",")]
        rows = tuple(row for row in rows if _fits(cell_of(row, name), patterns))
    if select and not rows:
        raise InputError(
            "no recording of the study agrees with this selection",
            where=" ".join(f"--select {text}" for text in select),
            remedy="See the values with `stereotrack study status`.",
        )
    return rows


def cell_of(row: StudyRow, column: str) -> str:
    """What a row says in a column."""
    return str(getattr(row, column) if column in OWN_COLUMNS else row.factors.get(column, ""))


def _fits(cell: str, patterns: Iterable[str]) -> bool:
    return any(cell == pattern or fnmatchcase(cell, pattern) for pattern in patterns)
