"""The description of a study: its recordings with their factors, settings, values and seeds."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from pathlib import Path, PurePosixPath
from typing import Any

import tomli_w

from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError, did_you_mean
from stereotrack_core.parameters import Value, parsed_settings
from stereotrack_core.plain_data import Kind, check_kind
from stereotrack_core.project.whereabouts import projects_of
from stereotrack_core.recording.folder import DESCRIPTION
from stereotrack_core.recording.selection import seeds_of
from stereotrack_core.recording.toml_table import load_toml
from stereotrack_core.study import points
from stereotrack_core.tracking.presets import preset
from stereotrack_core.work import NO_WORK, Work

SUFFIX = ".study.toml"
OWN_COLUMNS = ("recording", "project", "keypoints")
"""What the program knows of a recording; all else that a description says of it is a factor."""

RESULT_COLUMNS = ("run", "preset", "changes", "seed", "measure", "statistic", "unit", "value")
"""Columns of the exported table; no factor may have one of these names."""

_TEXTS = ("preset", "frames", "views", "init", "layout", "person")
_KIND: Kind = {
    **dict.fromkeys(_TEXTS, str),
    "smooth": bool,
    "seeds": [int],
    "settings": {str: (bool, int, float, str)},
    "grid": {str: [(bool, int, float, str)]},
    "recording": [{str: (str, bool, int, float)}],
}
_REMEDY = "See docs/studies.md for what a study file contains."


@dataclass(frozen=True)
class StudyRecording:
    """A recording of a study."""

    recording: str  # folder, relative to the study file, with ``/``; absolute on another drive
    project: str = ""  # project file whose reference is used; empty if there is none
    keypoints: str = ""  # project or detector's file whose keypoints are measurements
    factors: Mapping[str, str] = field(default_factory=dict)  # subject, condition and so on

    def cell(self, column: str) -> str:
        """The value of one of the program's columns or of a factor."""
        own = column in OWN_COLUMNS
        return str(getattr(self, column) if own else self.factors.get(column, ""))


@dataclass(frozen=True, kw_only=True)
class StudySettings:
    """Settings that all runs share, and the values that are varied, in the words of the options."""

    preset: str = "accurate"
    changes: tuple[str, ...] = ()  # ``NAME=VALUE`` for parameters that differ from the preset
    grid: tuple[str, ...] = ()  # ``NAME=a,b,c``: all combinations are tried
    seeds: str = "0"
    frames: str | None = None
    views: str | None = None
    init: str = "auto"
    smooth: bool = False
    layout: str | None = None  # order of the keypoints in files without names
    person: str | None = None  # name or number of the person in keypoints of several

    def all_points(self) -> tuple[points.Point, ...]:
        """Points of the grid. Raises InputError if a value is not accepted."""
        return points.grid_points([points.parsed_axis(text) for text in self.grid])

    def check(self) -> None:
        """Refuse what makes no sense for any recording. Raises InputError."""
        preset(self.preset, self.changes)
        seeds_of(self.seeds)
        self.all_points()

    def to_dict(self) -> dict[str, Any]:
        """The settings as TOML holds them; what is as usual is left out."""
        usual = StudySettings()
        texts = {name: getattr(self, name) for name in (*_TEXTS, "smooth")}
        content: dict[str, Any] = {
            name: value for name, value in texts.items() if value != getattr(usual, name)
        }
        content = {"preset": self.preset, "seeds": seeds_of(self.seeds), **content}
        rows = points.parameter_rows()
        if self.changes:
            named = parsed_settings(self.changes)
            content["settings"] = {name: rows[name].checked(named[name]) for name in named}
        if self.grid:
            axes = [points.parsed_axis(text) for text in self.grid]
            content["grid"] = {axis.name: list(axis.values) for axis in axes}
        return content

    @classmethod
    def of(cls, content: Mapping[str, Any], where: str) -> StudySettings:
        """Read :meth:`to_dict`. Raises InputError for a value that is not accepted."""
        grid = content.get("grid", {})
        found = cls(
            changes=tuple(f"{k}={_text(v)}" for k, v in content.get("settings", {}).items()),
            grid=tuple(f"{k}={','.join(map(_text, v))}" for k, v in grid.items()),
            seeds=",".join(map(str, content.get("seeds", (0,)))),
            **{name: content[name] for name in (*_TEXTS, "smooth") if name in content},
        )
        try:
            found.check()
        except InputError as error:
            raise InputError(error.what, f"{where}, {error.where}", error.remedy) from None
        return found


@dataclass(frozen=True)
class Study:
    """The content of a study file; of a sweep, what the command says."""

    path: Path
    rows: tuple[StudyRecording, ...] = ()
    settings: StudySettings = StudySettings()

    @property
    def factors(self) -> tuple[str, ...]:
        """Names of the factors, in the order in which recordings mention them."""
        return tuple(dict.fromkeys(name for row in self.rows for name in row.factors))

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
        """Folder of the study's runs."""
        return self.folder / f"{self.stem}.runs"

    @property
    def table(self) -> Path:
        """Table with a row for each run."""
        return self.runs / "runs.csv"

    def place(self, relative: str) -> Path:
        """The file or folder that a description names."""
        return Path(os.path.normpath(self.folder / relative))

    def rows_besides(self, folder: Path) -> tuple[StudyRecording, ...]:
        """All recordings but the one in this folder."""
        return tuple(row for row in self.rows if self.place(row.recording) != folder)

    def relative(self, path: Path) -> str:
        """How a description names a file or folder."""
        path = path.absolute()
        try:
            return Path(os.path.relpath(path, self.folder)).as_posix()
        except ValueError:  # another drive of Windows
            return path.as_posix()

    def runs_of(self, row: StudyRecording) -> Path:
        """Folder of the runs of a recording, by where it is listed, not by where it is."""
        path = PurePosixPath(row.recording)
        named = ["up" if part == ".." else part for part in path.parts if part != "."]
        return self.runs.joinpath(*(named[1:] if path.is_absolute() else named))


def check_name(path: Path) -> None:
    """Refuse a name that no study file has. Raises InputError with one that would do."""
    if not path.name.endswith(SUFFIX) or path.name == SUFFIX:
        stem = path.name.split(".")[0] or "walks"
        what = f"the name of a study must end in {SUFFIX}"
        raise InputError(what, path, f"Use the name {stem}{SUFFIX}.")


def read_study(path: Path) -> Study:
    """Read a study file, without looking at its folders. Raises InputError."""
    check_name(path)
    content = load_toml(path)
    unknown = [key for key in content if key not in _KIND]
    if unknown:
        known = did_you_mean(unknown[0], _KIND)
        raise InputError(f"unknown key {unknown[0]!r}", path, known + _REMEDY)
    check_kind(content, _KIND, str(path), _REMEDY)
    for name in (*content.get("settings", ()), *content.get("grid", ())):
        points.checked_name(name, str(path))
    rows = tuple(_row(one) for one in content.get("recording", ()))
    study = Study(path, rows, StudySettings.of(content, str(path)))
    check_rows(study)
    return study


def _row(values: Mapping[str, Value]) -> StudyRecording:
    texts = {name: _text(value) for name, value in values.items()}
    own = {name: texts.pop(name, "") for name in OWN_COLUMNS}
    return StudyRecording(**own, factors=texts)


def check_rows(study: Study) -> None:
    """Refuse recordings without a folder or listed twice, and factors named as a result column."""
    seen: set[Path] = set()
    for number, row in enumerate(study.rows, start=1):
        place = study.place(row.recording)
        if not row.recording or place in seen:
            raise InputError(
                f"the recording {row.recording!r} is listed twice"
                if row.recording
                else f"recording number {number} has no folder",
                study.path,
                "Delete one of the two." if row.recording else "Write it, or delete it.",
            )
        seen.add(place)
    taken = [name for name in study.factors if name in RESULT_COLUMNS]
    if taken:
        what = f"a factor is called {taken[0]!r}, which is a column of the results"
        raise InputError(what, study.path, "Give it another name.")


def write_study(study: Study) -> None:
    """Write a study file; a write that fails leaves the old one. Raises InputError."""
    rows = []
    for row in study.rows:
        own = {name: getattr(row, name) for name in OWN_COLUMNS if getattr(row, name)}
        rows.append({**own, **row.factors})
    write_file(study.path, tomli_w.dumps({**study.settings.to_dict(), "recording": rows}))


def selected(study: Study, select: Sequence[str]) -> tuple[StudyRecording, ...]:
    """Recordings that agree with all of ``COLUMN=a,b*``, in their order. Raises InputError."""
    rows = study.rows
    known = (*OWN_COLUMNS, *study.factors)
    for text in select:
        name, sign, values = (part.strip() for part in text.partition("="))
        if not sign or name not in known:
            raise InputError(
                f"the study has no column {name!r}" if sign else f"{text!r} cannot be read",
                "--select",
                f"{did_you_mean(name, known)}Write COLUMN=VALUE; the columns are: "
                f"{', '.join(known)}.",
            )
        patterns = [value.strip() for value in values.split(",")]
        rows = tuple(
            row
            for row in rows
            if row.cell(name) in patterns or any(fnmatchcase(row.cell(name), p) for p in patterns)
        )
    if select and not rows:
        what = "no recording of the study agrees with this selection"
        remedy = "See the values with `stereotrack study status`."
        raise InputError(what, " ".join(f"--select {text}" for text in select), remedy)
    return rows


def cell_of(value: Value) -> str | float | int:
    """A value as an option and a table take it, without rounding."""
    return ("yes" if value else "no") if isinstance(value, bool) else value


def _text(value: Value) -> str:
    return str(cell_of(value))


_DEEPEST = 8  # levels of folders below a given one that are looked through


@dataclass(frozen=True)
class Listed:
    """A study with further recordings; nothing is written yet."""

    study: Study
    added: tuple[str, ...]


def with_recordings(study: Study, folders: Sequence[Path], work: Work = NO_WORK) -> Listed:
    """List recordings behind those listed, each with its newest project. InputError, Cancelled."""
    rows = {study.place(row.recording): row for row in study.rows}
    added = []
    for folder in _found(folders):
        work.step(0.0, str(folder))
        if folder not in rows:
            added.append(study.relative(folder))
            rows[folder] = StudyRecording(added[-1])
        row = rows[folder]
        if not (row.project and study.place(row.project).is_file()):
            newest = next(iter(projects_of(folder)), None)
            if newest is not None:
                rows[folder] = replace(row, project=study.relative(newest))
    return Listed(replace(study, rows=tuple(rows.values())), tuple(added))


def recordings_below(folder: Path) -> Iterator[Path]:
    """Recordings in a folder and below it, by name; hidden folders are left out."""
    for path, folders, files in os.walk(folder):
        here = Path(path)
        if DESCRIPTION in files:
            yield here
        deep = DESCRIPTION in files or len(here.relative_to(folder).parts) >= _DEEPEST
        folders[:] = [] if deep else sorted(name for name in folders if not name.startswith("."))


def _found(folders: Iterable[Path]) -> Iterator[Path]:
    for folder in folders:
        below = list(recordings_below(folder.absolute()))
        if not below:
            remedy = "Give a folder with recordings below it: folders with a recording.toml."
            raise InputError("there is no recording in this folder", folder, remedy)
        yield from below
