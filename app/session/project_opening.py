"""Find, make or open the project of a recording; off the window's thread."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from stereotrack_core.errors import Finding, InputError
from stereotrack_core.project.database import ProjectDamaged, ProjectInUse
from stereotrack_core.project.project import Project
from stereotrack_core.project.whereabouts import documents_folder, project_path_for, projects_of

from ..widgets.forms.message import Message

_READING = "It is open read-only. {}"


@dataclass(frozen=True, eq=False)
class OpenedProject:
    """A project that is open, and what the person should know."""

    project: Project
    folder: Path | None
    """Its recording; None where that was not found."""
    messages: tuple[Message, ...]
    in_use: bool = False
    """Whether another program has it, so that it is open for reading only."""


@dataclass(frozen=True)
class Wishes:
    """How projects are to be opened."""

    who: str = ""
    """Annotator."""
    home: Path | None = None
    """Folder of new projects; None: beside their recordings."""
    makes: bool = True
    """Whether a recording that has no project gets one."""


def project_of_recording(folder: Path, wishes: Wishes) -> OpenedProject | None:
    """Open the newest project of a recording, or make one; None where none shall be made.

    Raises
    ------
    InputError
        Where it cannot be opened even for reading, or none can be made.
    """
    found = projects_of(folder, wishes.home)
    if found:
        opened = open_project(found[0], wishes)
        if len(found) == 1:
            return opened
        several = Message(
            "note",
            f"this recording has {len(found)} projects; the most recently changed one is open",
            found[0].name,
            "To open another one, open its project file.",
        )
        messages = (*opened.messages, several)
        return OpenedProject(opened.project, opened.folder, messages, opened.in_use)
    if not wishes.makes:
        return None
    path = project_path_for(folder, documents_folder(), wishes.home)
    project = Project.create(path, folder, who=wishes.who, interactive=True)
    messages = tuple(message_of_finding(note) for note in project.notes)
    if path.parent != folder.resolve().parent and wishes.home is None:
        elsewhere = Message(
            "note",
            "the recording's folder is write-protected, so its project is stored elsewhere",
            str(path),
            "Clicks are saved there and are found again when the recording is opened.",
        )
        messages = (*messages, elsewhere)
    return OpenedProject(project, folder, messages)


def open_project(path: Path, wishes: Wishes, *, take_over: bool = False) -> OpenedProject:
    """Open a project file and look for its recording; for reading where it cannot be written.

    Raises
    ------
    InputError
        Where it is no project, or is damaged.
    """
    messages: tuple[Message, ...] = ()
    in_use = False
    try:
        project = Project.open(path, who=wishes.who, take_over=take_over, interactive=True)
    except ProjectDamaged:
        raise
    except InputError as error:
        project = _opened_for_reading(path, error)
        in_use = isinstance(error, ProjectInUse)
        messages = (Message("warning", error.what, error.where, _READING.format(error.remedy)),)
    try:
        whereabouts = project.find_recording()
    except InputError:
        project.close()
        raise
    found = (*project.notes, *([whereabouts.finding] if whereabouts.finding else []))
    messages = (*messages, *(message_of_finding(note) for note in found))
    return OpenedProject(project, whereabouts.folder, messages, in_use)


def message_of_finding(finding: Finding) -> Message:
    """A finding as the message bar shows it."""
    return Message(finding.severity, finding.what, finding.where, finding.remedy)


def _opened_for_reading(path: Path, error: InputError) -> Project:
    """Open for reading what cannot be written; the first complaint stays where that fails too."""
    try:
        return Project.open(path, read_only=True)
    except InputError:
        raise error from None
