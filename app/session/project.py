"""The project of the window: opened with its recording, edited, closed; nothing to be saved."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from stereotrack_core.errors import Finding, InputError
from stereotrack_core.locks import user
from stereotrack_core.project.database import ProjectDamaged, ProjectInUse
from stereotrack_core.project.edit import Edit
from stereotrack_core.project.history import Changed
from stereotrack_core.project.project import Project
from stereotrack_core.project.whereabouts import documents_folder, project_path_for, projects_of
from stereotrack_core.recording.description import Subject

from .base import Base
from .changes import Part
from .jobs import Job, NewestJob, Task
from .messages import Message, message_of, stored_text

_ANNOTATOR = "annotator"
_HOME = "projects_folder"


class ProjectPresenter:
    """Keeps the project that belongs to the open recording."""

    def __init__(self, base: Base) -> None:
        self._changes, self._tasks, self._tell = base.changes, base.tasks, base.tell
        self._document, self._settings = base.document, base.settings
        self._opened: OpenedProject | None = None
        self._waiting: OpenedProject | None = None
        self._of_file, self._of_recording = NewestJob(self._tasks), NewestJob(self._tasks)
        self._problem = ""
        self._frame = 0
        self.makes = True  # whether a recording that has no project gets one

    # ---- facts

    @property
    def project(self) -> Project | None:
        return self._opened.project if self._opened is not None else None

    @property
    def path(self) -> Path | None:
        return self._opened.project.path if self._opened is not None else None

    @property
    def in_use(self) -> bool:
        """Whether another program has the project, which is open for reading only therefore."""
        return self._opened is not None and self._opened.in_use

    @property
    def annotator(self) -> str:
        """Name that edits are signed with; empty: the user's name on this machine."""
        return stored_text(self._settings, _ANNOTATOR)

    def set_annotator(self, name: str) -> None:
        self._settings.setValue(_ANNOTATOR, name.strip())
        if self.project is not None:
            self.project.who = name.strip() or user()
        self._changes.tell(Part.PROJECT_OPENED)

    @property
    def home(self) -> Path | None:
        """Folder of new projects; None: beside their recordings."""
        home = stored_text(self._settings, _HOME)
        return Path(home) if home else None

    def set_home(self, folder: Path | None) -> None:
        self._settings.setValue(_HOME, str(folder) if folder is not None else "")

    def why_no_edit(self) -> str:
        if self.project is None:
            if self._of_file.busy or self._of_recording.busy:
                return "The project is still loading."
            return self._problem or "No project is open. Open or create one first."
        if self.project.read_only:
            why = "another program has locked it" if self.in_use else "it is write-protected"
            return f"The project is open read-only: {why}."
        return ""

    def subject(self) -> Subject | None:
        """Subject whose body is tracked: the project's, else the recording's."""
        recording = self._document.recording
        own = None if self.project is None else self.project.subject()
        return own if own is not None or recording is None else recording.subject

    # ---- opening and closing

    def open_file(self, path: Path, frame: int = 0, *, take_over: bool = False) -> None:
        """Open a project file and its recording; in the background."""
        self._give_up_waiting()
        self._frame, who, title = frame, self.annotator, f"opening {path.name}"

        def read(_task: Task) -> OpenedProject:
            return open_project(path, who, take_over=take_over)

        def begin() -> None:
            if self.path == path.resolve():  # its lock is our own
                self.close()
            taken, close = (self._on_file_opened, self._on_failed), OpenedProject.close
            self._of_file.run(Job(title, read, *taken, discard=close))

        self._tasks.after_writes(begin)

    def use_recording(self, folder: Path, *, even_another: bool = False) -> None:
        """Say where the recording of the project that was opened last is.

        Raises InputError where it is no usable recording, or another one that was not allowed for.
        """
        waiting = self._waiting
        if waiting is None:
            return
        if not waiting.project.read_only:
            waiting.project.use_recording(folder, even_another=even_another)
        self._waiting = replace(waiting, folder=folder, messages=())
        self._document.open(folder, self._frame)

    def give_up(self) -> None:
        """Do without the project that is being opened, or whose recording nobody knows."""
        self._of_file.give_up()
        self._give_up_waiting()

    def close(self) -> None:
        """Give the project back, when all that is being written to it is there."""
        self._of_recording.give_up()
        self._tasks.finish_writes()
        if self._opened is not None:
            self._changes.tell(Part.PROJECT_CLOSING)
        opened, self._opened = self._opened, None
        self._problem = ""
        if opened is not None:
            opened.close()
            self._changes.tell(Part.PROJECT_CLOSED)

    # ---- edits

    def apply(self, edit: Edit, *, continues: bool = False) -> Changed | None:
        """Make an edit; what stands against it is said in a message."""
        why_not = self.why_no_edit()
        if why_not or self.project is None:
            self._tell(Message("warning", "Editing is not possible now", remedy=why_not))
            return None
        try:
            return self.project.apply(edit, continues=continues)
        except InputError as error:
            self._tell(message_of(error))
            return None

    # ---- following the document

    def _on_file_opened(self, opened: OpenedProject) -> None:
        self._give_up_waiting()
        self._waiting = opened
        if opened.folder is not None:
            self._document.open(opened.folder, self._frame)
            return
        for message in opened.messages:
            self._tell(message)
        self._changes.tell(Part.RECORDING_MISSING, opened.project.path)

    def follow_recording(self) -> None:
        """Take the project that waits for the open recording, or open or make its own."""
        recording = self._document.recording
        if recording is None:
            return
        folder = recording.folder.resolve()
        waiting, self._waiting = self._waiting, None
        if waiting is not None and waiting.folder is not None:
            if waiting.folder.resolve() == folder:
                self._take(waiting)
                return
            waiting.close()
        find = partial(project_of_recording, folder, self.annotator, self.home, makes=self.makes)
        title, taken = f"opening the project of {folder.name}", (self._take, self._on_failed)
        self._of_recording.run(
            Job(title, lambda _task: find(), *taken, discard=lambda one: one and one.close())
        )

    def _take(self, opened: OpenedProject | None) -> None:
        if opened is None:
            self._changes.tell(Part.PROJECT_FOLLOWED)
            return
        self._opened = opened
        # called in whichever thread the edit was made
        opened.project.on_change(partial(self._changes.tell, Part.EDIT))
        for read in (opened.project.history.to_undo, opened.project.history.to_redo):
            read()  # a damaged history is told by the task, before anybody asks for it
        self._changes.tell(Part.PROJECT_OPENED)
        self._changes.tell(Part.PROJECT_FOLLOWED)

        def tell_of() -> None:
            for message in opened.messages if opened is self._opened else ():
                self._tell(message)

        # what was said about the recording before is cleared away first
        self._changes.loop.post(tell_of)

    def _give_up_waiting(self) -> None:
        waiting, self._waiting = self._waiting, None
        if waiting is not None:
            waiting.close()

    def _on_failed(self, error: Exception) -> None:
        self._tasks.failed(error)
        self._problem = f"The project could not be opened: {message_of(error).what}."
        self._changes.tell(Part.PROJECT_FOLLOWED)


_READING = "It is open read-only. {}"


@dataclass(frozen=True, eq=False)
class OpenedProject:
    """A project that is open, and what the person should know."""

    project: Project
    folder: Path | None  # its recording; None where that was not found
    messages: tuple[Message, ...]
    in_use: bool = False  # whether another program has it, so that it is open for reading only

    def close(self) -> None:
        self.project.close()


def project_of_recording(
    folder: Path, who: str, home: Path | None, *, makes: bool
) -> OpenedProject | None:
    """Open the newest project of a recording, or make one; None where none shall be made.

    Raises InputError where it cannot be opened even for reading, or none can be made.
    """
    found = projects_of(folder, home)
    if found:
        opened = open_project(found[0], who)
        if len(found) == 1:
            return opened
        what = f"this recording has {len(found)} projects; the most recently changed one is open"
        remedy = "To open another one, open its project file."
        several = Message("note", what, found[0].name, remedy)
        return replace(opened, messages=(*opened.messages, several))
    if not makes:
        return None
    path = project_path_for(folder, documents_folder(), home)
    project = Project.create(path, folder, who=who)
    messages = tuple(message_of_finding(note) for note in project.notes)
    if path.parent != folder.resolve().parent and home is None:
        what = "the recording's folder is write-protected, so its project is stored elsewhere"
        remedy = "Clicks are saved there and are found again when the recording is opened."
        messages = (*messages, Message("note", what, str(path), remedy))
    return OpenedProject(project, folder, messages)


def open_project(path: Path, who: str, *, take_over: bool = False) -> OpenedProject:
    """Open a project file and look for its recording; for reading where it cannot be written.

    Raises InputError where it is no project, or is damaged.
    """
    messages: tuple[Message, ...] = ()
    in_use = False
    try:
        project = Project.open(path, who=who, take_over=take_over)
    except ProjectDamaged:
        raise
    except InputError as error:
        try:
            project = Project.open(path, read_only=True)
        except InputError:  # the first complaint says more
            raise error from None
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
