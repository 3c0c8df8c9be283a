"""Recordings and projects below folders, and those of a study found again when folders move."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from stereotrack_core.errors import Finding, InputError
from stereotrack_core.project.whereabouts import SUFFIX, documents_folder, stated_folders
from stereotrack_core.recording.folder import DESCRIPTION, fingerprint, open_recording
from stereotrack_core.study.file import Study, StudyRow

_DEEPEST = 8
_NEAR = 3
"""Levels of folders below the study's, and around an old place, in which is looked."""

_MOST_FOLDERS = 20_000
"""That are looked into for what has moved: more are somebody's whole drive."""


@dataclass(frozen=True)
class Place:
    """Where a row's recording and project are now; None for what is not there."""

    folder: Path | None
    project: Path | None
    moved: bool = False
    """Whether one of them is not where the study file says."""
    findings: tuple[Finding, ...] = ()
    """What a person should know about that."""


def fingerprint_of(folder: Path) -> str:
    """Fingerprint of a recording; empty where it cannot be opened."""
    try:
        return fingerprint(open_recording(folder))
    except (InputError, OSError):
        return ""


def is_recording(folder: Path) -> bool:
    """Whether a folder is a recording, usable or not."""
    return (folder / DESCRIPTION).is_file()


def recordings_below(folder: Path, deepest: int = _DEEPEST) -> Iterator[Path]:
    """Recordings in a folder and below it, in the order of their names; hidden folders are not
    looked into.
    """
    return (path for path, names in _walk(folder, deepest) if DESCRIPTION in names)


def projects_below(folders: Iterable[Path], deepest: int = _DEEPEST) -> Iterator[Path]:
    """Project files in these folders and below them, each once."""
    seen: set[Path] = set()
    for folder in folders:
        for path, names in _walk(folder, deepest):
            for name in names:
                project = path / name
                if name.endswith(SUFFIX) and project not in seen:
                    seen.add(project)
                    yield project


def _walk(folder: Path, deepest: int) -> Iterator[tuple[Path, list[str]]]:
    """Folders with the names of their files; nothing below a recording."""
    root = folder.absolute()
    for count, (path, folders, files) in enumerate(os.walk(root)):
        here = Path(path)
        depth = len(here.relative_to(root).parts)
        closed = DESCRIPTION in files or depth >= deepest or count >= _MOST_FOLDERS
        folders[:] = [] if closed else sorted(n for n in folders if not n.startswith("."))
        yield here, sorted(files)


class ProjectIndex:
    """Which projects belong to which recording; every project file is opened once."""

    def __init__(self, projects: Iterable[Path]) -> None:
        self._of: dict[Path, list[Path]] = {}
        for project in projects:
            for folder in dict.fromkeys(stated_folders(project)):
                self._of.setdefault(folder, []).append(project)

    @staticmethod
    def around(study: Study, recordings: Iterable[Path]) -> ProjectIndex:
        """Of projects below a study's folder, beside recordings and in the user's documents."""
        beside = dict.fromkeys(path.parent for path in recordings)
        places = [*beside, documents_folder()]
        found = (*projects_below([study.folder]), *projects_below(places, 0))
        return ProjectIndex(dict.fromkeys(found))

    def of(self, folder: Path) -> Path | None:
        """The project of a recording that was changed last; None where there is none."""
        found = self._of.get(folder.absolute(), []) or self._of.get(folder.resolve(), [])
        return max(found, key=lambda path: path.stat().st_mtime, default=None)


class Finder:
    """Finds what a study lists, in its place or elsewhere.

    Folders are only looked through where something is missing.

    Parameters
    ----------
    fingerprint : callable, optional
        Gives the fingerprint of a recording; for those who remember them.
    """

    def __init__(self, study: Study, fingerprint: Callable[[Path], str] = fingerprint_of) -> None:
        self._study = study
        self._fingerprint = fingerprint
        self._around: dict[Path, list[Path]] = {}
        self._listed = {study.place(row.recording) for row in study.rows}

    def place(self, row: StudyRow) -> Place:
        """Where a row's recording and project are now."""
        study, old = self._study, self._study.place(row.recording)
        folder, findings = self._recording(row, old)
        project = study.place(row.project) if row.project else None
        moved = folder not in (None, old)
        if project is not None and not project.is_file():
            found = self._project(row, old, folder)
            findings.append(_told("project", row.project, project, found))
            moved, project = moved or found is not None, found
        return Place(folder, project, moved, tuple(findings))

    def _recording(self, row: StudyRow, old: Path) -> tuple[Path | None, list[Finding]]:
        if is_recording(old):
            return old, []
        same = []
        if row.fingerprint:
            same = [
                path for path in self._candidates(old) if self._fingerprint(path) == row.fingerprint
            ]
        if len(same) > 1:
            named = [path for path in same if path.name == old.name]
            same = named if len(named) == 1 else same
        if len(same) > 1:
            places = ", ".join(self._study.relative(path) for path in same)
            what = f"the recording was not found, and several folders have its content: {places}"
            remedy = "Write the right one into the study file."
            return None, [Finding("error", row.recording, what, remedy)]
        found = same[0] if same else None
        return found, [_told("recording", row.recording, old, found)]

    def _project(self, row: StudyRow, old: Path, folder: Path | None) -> Path | None:
        """A project of the same name near the recording that says it is the recording's."""
        name = Path(row.project).name
        near = [] if folder is None else [folder.parent / name]
        near += [path for path in self._projects if path.name == name]
        for path in near:
            if path.is_file() and {old, folder} & set(stated_folders(path)):
                return path
        return None

    @cached_property
    def _projects(self) -> list[Path]:
        return list(projects_below([self._study.folder]))

    def _candidates(self, old: Path) -> list[Path]:
        """Recordings that are not listed, below the study's folder and near an old place."""
        parents = [path for path in (old.parent, old.parent.parent) if path.is_dir()]
        found: list[Path] = []
        for root, deepest in ((self._study.folder, _DEEPEST), *((one, _NEAR) for one in parents)):
            if root not in self._around:
                self._around[root] = [
                    path for path in recordings_below(root, deepest) if path not in self._listed
                ]
            found += self._around[root]
        return list(dict.fromkeys(found))


def _told(what: str, listed: str, old: Path, found: Path | None) -> Finding:
    if found is None:
        return Finding(
            "error",
            listed,
            f"the {what} was not found",
            f"Move it back to {old}, or write its place into the study file.",
        )
    return Finding(
        "note",
        listed,
        f"the {what} has moved to {found}",
        "`stereotrack study create` writes the new place into the study file.",
    )
