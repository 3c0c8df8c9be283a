"""Projects that commands are given: opened, with everything told that the person should know."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from stereotrack_core.cli.output import say
from stereotrack_core.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Iterable

    from stereotrack_core.project.project import Project
    from stereotrack_core.recording.description import Recording
    from stereotrack_core.recording.finding import Finding


def open_project(path: Path, *, read_only: bool = True) -> Project:
    """Open a project and say on standard error what its file has to tell."""
    from stereotrack_core.project.project import Project

    project = Project.open(path, read_only=read_only)
    say_notes(project.notes)
    return project


def say_notes(notes: Iterable[Finding]) -> None:
    """Say what the person should know about a project."""
    for note in notes:
        say(f"{note.severity}: {note.where}: {note.what}. {note.remedy}")


def recording_of(project: Project) -> Recording:
    """The recording of a project.

    Raises
    ------
    InputError
        Where it is not found.
    """
    from stereotrack_core.recording.folder import open_recording

    place = project.find_recording()
    if place.finding is not None and place.folder is not None:
        say(f"{place.finding.severity}: {place.finding.where}: {place.finding.what}.")
    if place.folder is None:
        raise InputError(
            "the project's recording is not found",
            where=project.recording_place().absolute,
            remedy="Move it back beside the project, or choose its folder in the workbench.",
        )
    return open_recording(place.folder)
