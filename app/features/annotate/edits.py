"""Edits of the project, beside the window's thread where they are large."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QObject, Signal, Slot

from stereotrack_core.errors import InputError
from stereotrack_core.project.edit import Edit
from stereotrack_core.project.history import Changed
from stereotrack_core.project.project import Project

from ...services.failures import message_of
from ...services.tasks.task import TaskList

_MANY_FRAMES = 300


class EditWork(QObject):
    """Makes edits, and says what was done or what is wrong.

    Signals
    -------
    said : str
    message : Message
    """

    said = Signal(str)
    message = Signal(object)

    def __init__(self, tasks: TaskList, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._tasks = tasks

    def do(self, project: Project, make: Callable[[], Edit], *, frames: int = 1) -> None:
        """Make an edit.

        Parameters
        ----------
        project : Project
        make : callable
            Gives the edit; may raise InputError.
        frames : int
            How many frames it is about; with many of them it is made in the background.
        """
        if frames > _MANY_FRAMES:
            self._tasks.begin("editing", lambda _task: project.apply(make()), self._on_done)
            return
        try:
            self._on_done(project.apply(make()))
        except InputError as error:
            self.message.emit(message_of(error))

    @Slot(object)
    def _on_done(self, changed: Changed | None) -> None:
        self.said.emit(f"Done: {changed.words}." if changed is not None else "Nothing to change.")
