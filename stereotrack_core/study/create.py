"""List recordings in a study file, or find those to add; what a person wrote into it stays."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from stereotrack_core.errors import Cancelled, Finding, InputError
from stereotrack_core.project.whereabouts import SUFFIX, stated_folders
from stereotrack_core.recording.folder import DESCRIPTION
from stereotrack_core.study.file import (
    OWN_COLUMNS,
    RESULT_COLUMNS,
    Study,
    StudyRow,
    check_name,
    read_study,
    write_study,
)
from stereotrack_core.study.places import (
    Finder,
    ProjectIndex,
    fingerprint_of,
    is_recording,
    recordings_below,
)

_NAMED = 5
"""Folders that a sentence names."""

_NONE_THERE = "there is no recording in this folder"
_NONE_REMEDY = "Give a folder with recordings below it: folders with a recording.toml."

_FORM = "Write names of columns as subject/condition/repetition, or {subject}/{condition}_{day}."


@dataclass(frozen=True)
class Created:
    """What listing has changed."""

    study: Study
    added: tuple[str, ...]
    """Recordings that are new in the list."""
    moved: tuple[str, ...]
    """Recordings and projects whose new places were written."""
    findings: tuple[Finding, ...]


class Pattern:
    """Factors in the names of folders.

    ``subject/condition`` stands for ``{subject}/{condition}``; a part ``*`` may be anything. Raises
    InputError where it cannot be meant, naming `where` it was given.
    """

    def __init__(self, text: str, where: str = "--pattern") -> None:
        self.text = text
        parts = [part.strip() for part in text.strip("/").split("/")]
        braced = [part if "{" in part or part == "*" else f"{{{part}}}" for part in parts]
        whole = "/".join(braced)
        self._depth = len(parts)
        self.names = tuple(re.findall(r"\{([^{}]*)\}", whole))
        taken = {*OWN_COLUMNS, *RESULT_COLUMNS}
        wrong = [name for name in self.names if not re.fullmatch(r"[^\W\d]\w*", name)]
        wrong += [name for name in self.names if name in taken]
        if wrong or not self.names or len(set(self.names)) < len(self.names):
            what = f"{wrong[0]!r} cannot be a column" if wrong else f"{text!r} cannot be read"
            raise InputError(what, where=where, remedy=f"{_FORM} Use each name once.")
        pieces = re.split(r"(\{[^{}]*\}|\*)", whole)
        self._form = re.compile(
            "".join(
                f"(?P<{piece[1:-1]}>[^/]+?)" if piece.startswith("{") else
                "[^/]*" if piece == "*" else re.escape(piece)
                for piece in pieces
            )
        )  # fmt: skip

    def factors(self, relative: str) -> dict[str, str] | None:
        """Values by name in a path with ``/``; None where it does not fit."""
        found = self._form.fullmatch(relative)
        return None if found is None else found.groupdict()

    def factors_of_end(self, path: str) -> dict[str, str] | None:
        """The same of the last folders of a path: as many as the pattern has."""
        return self.factors("/".join(path.split("/")[-self._depth :]))


def create_study(
    path: Path,
    folders: Sequence[Path],
    pattern: Pattern | None = None,
    *,
    on_progress: Callable[[float, str], None] = lambda _share, _words: None,
    cancelled: Callable[[], bool] = lambda: False,
) -> Created:
    """List all recordings below folders in a study file, which is made or added to.

    Rows that are there keep what a person wrote: only empty cells are filled, and places that have
    changed are written. Raises InputError where a folder holds no recording, or the file cannot be
    written, and Cancelled.
    """
    check_name(path)
    study = read_study(path) if path.exists() else Study(path)
    found = _found(folders)
    names = () if pattern is None else pattern.names
    factors = tuple(dict.fromkeys((*study.factors, *names)))
    study = dataclasses.replace(study, factors=factors)
    projects = ProjectIndex.around(study, found)
    rows, moved, findings = _present(study, found, pattern, projects)
    listed = {study.place(row.recording) for row in rows}
    new = [folder for folder in found if folder not in listed]

    def filled(folder: Path) -> StudyRow:
        return _filled(study, StudyRow(study.relative(folder)), folder, pattern, found, projects)

    added = _read(new, filled, findings, on_progress, cancelled)
    findings += _unlike(pattern, [found[folder] for folder in new])
    made = dataclasses.replace(study, rows=(*rows, *added))
    write_study(made)
    _move_runs(study, made)
    names = tuple(row.recording for row in added)
    return Created(made, names, tuple(moved), tuple(findings))


@dataclass(frozen=True)
class Found:
    """What was found in folders and projects that a person named."""

    rows: tuple[StudyRow, ...]
    """Of recordings that the study does not list, or whose project was named."""
    listed: int
    """How many others are in the study already."""
    findings: tuple[Finding, ...]


def find_recordings(
    study: Study,
    paths: Sequence[Path],
    *,
    on_progress: Callable[[float, str], None] = lambda _share, _words: None,
    cancelled: Callable[[], bool] = lambda: False,
) -> Found:
    """Rows for the recordings in and below folders, and for those of project files.

    Nothing is written, and what holds no recording does not stop the others. Raises Cancelled.
    """
    findings: list[Finding] = []
    named = _projects(paths, findings)
    found = dict.fromkeys(named)
    for path in paths:
        if not path.name.endswith(SUFFIX):
            found |= dict.fromkeys(_below(path, findings))
    listed = {study.place(row.recording) for row in study.rows}
    moved = _moved(study, found, findings)
    wanted = [
        folder
        for folder in found
        if folder not in moved and (folder in named or folder not in listed)
    ]
    projects = ProjectIndex.around(study, wanted) if wanted else ProjectIndex(())

    def filled(folder: Path) -> StudyRow:
        project = study.relative(named[folder]) if folder in named else ""
        row = StudyRow(study.relative(folder), project)
        return _filled(study, row, folder, None, {}, projects)

    rows = _read(wanted, filled, findings, on_progress, cancelled)
    known = len(found) - len(wanted) - len(moved)
    return Found(tuple(rows), known, tuple(findings))


def _moved(study: Study, found: Collection[Path], findings: list[Finding]) -> set[Path]:
    """Folders among these where recordings are now that the study lists elsewhere."""
    finder, moved = Finder(study), set()
    for row in study.rows:
        folder = finder.place(row).folder
        if folder in found and folder not in (None, study.place(row.recording)):
            moved.add(folder)
            remedy = f"`stereotrack study create {folder} -o {study.path}` writes its new place."
            what = f"this is {row.recording}, which has moved here"
            findings.append(Finding("note", str(folder), what, remedy))
    return moved


def _projects(paths: Iterable[Path], findings: list[Finding]) -> dict[Path, Path]:
    """Project files by the folder of their recording."""
    found = {}
    for path in paths:
        if not path.name.endswith(SUFFIX):
            continue
        folder = next((one for one in stated_folders(path.absolute()) if is_recording(one)), None)
        if folder is None:
            remedy = "Open the project in the workbench: it asks for the folder."
            what = "the recording of this project was not found"
            findings.append(Finding("warning", str(path), what, remedy))
        else:
            found[folder] = path
    return found


def _below(path: Path, findings: list[Finding]) -> list[Path]:
    """Recordings in and below a folder, or that of a recording's description."""
    folder = path.parent if path.name == DESCRIPTION else path
    below = list(recordings_below(folder))
    if not below:
        findings.append(Finding("warning", str(path), _NONE_THERE, _NONE_REMEDY))
    return below


def _read(
    folders: Sequence[Path],
    filled: Callable[[Path], StudyRow],
    findings: list[Finding],
    on_progress: Callable[[float, str], None],
    cancelled: Callable[[], bool],
) -> list[StudyRow]:
    """Rows of recordings that are opened one by one."""
    rows = []
    for i, folder in enumerate(folders):
        if cancelled():
            raise Cancelled
        on_progress(i / len(folders), "reading recordings")
        rows.append(filled(folder))
        if not rows[-1].fingerprint:
            remedy = f"`stereotrack info {folder}` tells what is wrong."
            where = rows[-1].recording
            findings.append(Finding("warning", where, "it cannot be opened", remedy))
    return rows


def _unlike(pattern: Pattern | None, folders: Sequence[str]) -> list[Finding]:
    """What there is to say of new folders that do not fit the pattern, in one sentence."""
    unlike = [one for one in folders if pattern is not None and pattern.factors(one) is None]
    if pattern is None or not unlike:
        return []
    more = f" and {len(unlike) - _NAMED} more" if len(unlike) > _NAMED else ""
    what = f"these folders do not fit the pattern: {', '.join(unlike[:_NAMED])}{more}"
    remedy = "Fill in their cells by hand, or use another pattern."
    return [Finding("warning", f"--pattern {pattern.text}", what, remedy)]


def _found(folders: Iterable[Path]) -> dict[Path, str]:
    """Recordings, each with its path from the folder that was given."""
    found: dict[Path, str] = {}
    for folder in folders:
        root = folder.absolute()
        if not root.is_dir():
            raise InputError(
                "there is no such folder", where=str(folder), remedy="Correct the path."
            )
        own = {path: path.relative_to(root).as_posix() for path in recordings_below(root)}
        if not own:
            raise InputError(_NONE_THERE, where=str(folder), remedy=_NONE_REMEDY)
        for path, relative in own.items():
            found.setdefault(path, path.name if relative == "." else relative)
    return found


def _present(
    study: Study, found: dict[Path, str], pattern: Pattern | None, projects: ProjectIndex
) -> tuple[list[StudyRow], list[str], list[Finding]]:
    """Rows that the study has, with new places where they have moved."""
    finder = Finder(study)
    rows, moved, findings = [], [], []
    for row in study.rows:
        place = finder.place(row)
        if place.moved:
            moved.append(row.recording)
        findings += [one for one in place.findings if one.severity == "error"]
        if place.folder is not None:
            new = row.recording if not place.moved else study.relative(place.folder)
            row = dataclasses.replace(row, recording=new)
            row = _filled(study, row, place.folder, pattern, found, projects)
        if place.project is not None and place.moved:
            row = dataclasses.replace(row, project=study.relative(place.project))
        rows.append(row)
    return rows, moved, findings


def _filled(
    study: Study,
    row: StudyRow,
    folder: Path,
    pattern: Pattern | None,
    found: dict[Path, str],
    projects: ProjectIndex,
) -> StudyRow:
    """A row whose empty cells are filled with what is known."""
    project = None if row.project else projects.of(folder)
    known = None if pattern is None or folder not in found else pattern.factors(found[folder])
    factors = dict(row.factors)
    for name, value in (known or {}).items():
        factors[name] = factors.get(name) or value
    return dataclasses.replace(
        row,
        project=row.project if project is None else study.relative(project),
        fingerprint=row.fingerprint or fingerprint_of(folder),
        factors=factors,
    )


def _move_runs(before: Study, now: Study) -> None:
    """Let the study's runs of recordings that have moved follow their rows."""
    for old, new in zip(before.rows, now.rows[: len(before.rows)], strict=True):
        source, target = before.runs_of(old), now.runs_of(new)
        if source != target and source.is_dir() and not target.exists():
            target.parent.mkdir(parents=True, exist_ok=True)
            source.rename(target)
