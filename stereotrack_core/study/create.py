"""List recordings in a study; what a person wrote about those that are there stays."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from stereotrack_core.errors import Cancelled, Finding, InputError
from stereotrack_core.project.whereabouts import projects_of
from stereotrack_core.recording.folder import DESCRIPTION
from stereotrack_core.study.description import (
    OWN_COLUMNS,
    RESULT_COLUMNS,
    Study,
    StudyRecording,
)

_DEEPEST = 8
"""Levels of folders below a given one that are looked through."""

_FORM = "Write names of factors as subject/condition/repetition, or {subject}/{condition}_{day}."


class Pattern:
    """Factors in the names of folders.

    ``subject/condition`` stands for ``{subject}/{condition}``; a part ``*`` may be anything. Raises
    InputError if it cannot be understood.
    """

    def __init__(self, text: str, where: str = "--pattern") -> None:
        self.text = text
        parts = [part.strip() for part in text.strip("/").split("/")]
        whole = "/".join(part if "{" in part or part == "*" else f"{{{part}}}" for part in parts)
        self.names = tuple(re.findall(r"\{([^{}]*)\}", whole))
        taken = {*OWN_COLUMNS, *RESULT_COLUMNS}
        wrong = [n for n in self.names if not re.fullmatch(r"[^\W\d]\w*", n) or n in taken]
        if wrong or not self.names or len(set(self.names)) < len(self.names):
            what = f"{wrong[0]!r} cannot be a factor" if wrong else f"{text!r} cannot be read"
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
        """Values by name in a path with ``/``; None if it does not fit."""
        found = self._form.fullmatch(relative)
        return None if found is None else found.groupdict()


@dataclass(frozen=True)
class Listed:
    """A study with further recordings; nothing is written yet."""

    study: Study
    added: tuple[str, ...]
    findings: tuple[Finding, ...]


def with_recordings(
    study: Study,
    folders: Sequence[Path],
    pattern: Pattern | None = None,
    *,
    cancelled: Callable[[], bool] = lambda: False,
) -> Listed:
    """List all recordings in and below folders behind those that are listed.

    Only empty cells of listed recordings are filled. Raises InputError if a folder holds no
    recording, and Cancelled.
    """
    rows = {study.place(row.recording): row for row in study.rows}
    added, findings = [], []
    for folder, relative in _found(folders).items():
        if cancelled():
            raise Cancelled
        if folder not in rows:
            added.append(study.relative(folder))
            rows[folder] = StudyRecording(added[-1])
        factors = (pattern.factors(relative) if pattern is not None else None) or {}
        if pattern is not None and not factors:
            remedy = "Write its factors by hand, or use another pattern."
            what = "the folder does not fit the pattern"
            findings.append(Finding("warning", relative, what, remedy))
        rows[folder] = _filled(study, rows[folder], folder, factors)
    return Listed(replace(study, rows=tuple(rows.values())), tuple(added), tuple(findings))


def _filled(
    study: Study, row: StudyRecording, folder: Path, factors: dict[str, str]
) -> StudyRecording:
    """A row whose empty cells are filled with what is known."""
    project = row.project
    if not project or not study.place(project).is_file():
        newest = next(iter(projects_of(folder)), None)
        project = project if newest is None else study.relative(newest)
    told = {name: value for name, value in row.factors.items() if value}
    return replace(row, project=project, factors={**row.factors, **factors, **told})


def recordings_below(folder: Path) -> Iterator[Path]:
    """Recordings in a folder and below it, by name; hidden folders are left out."""
    for path, folders, files in os.walk(folder):
        here = Path(path)
        if DESCRIPTION in files:
            yield here
        deep = DESCRIPTION in files or len(here.relative_to(folder).parts) >= _DEEPEST
        folders[:] = [] if deep else sorted(name for name in folders if not name.startswith("."))


def _found(folders: Iterable[Path]) -> dict[Path, str]:
    """Recordings, each with its path from the folder that was given."""
    found: dict[Path, str] = {}
    for folder in folders:
        root = folder.absolute()
        below = {path: path.relative_to(root).as_posix() for path in recordings_below(root)}
        if not below:
            raise InputError(
                "there is no recording in this folder",
                where=str(folder),
                remedy="Give a folder with recordings below it: folders with a recording.toml.",
            )
        for path, relative in below.items():
            found.setdefault(path, path.name if relative == "." else relative)
    return found
