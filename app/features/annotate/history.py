"""Going to any place in a project's history by undo and redo."""

from __future__ import annotations

from PySide6.QtCore import QElapsedTimer, QObject, QTimer, Signal, Slot

from stereotrack_core.errors import InputError
from stereotrack_core.project.project import Project

_SLICE_MS = 25


class HistoryPresenter(QObject):
    """Undoes and redoes to any place in the history; the window stays alive meanwhile."""

    moved = Signal(int)
    """So many edits have been undone or redone since the jump began."""
    arrived = Signal()
    """The jump has ended: it is there, was stopped, or failed."""
    failed = Signal(object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._project: Project | None = None
        self._target: int | None = None
        self._count = 0
        self._timer = QTimer(self, interval=0)
        self._timer.timeout.connect(self._go_on)

    @property
    def jumping(self) -> bool:
        """Whether a jump is under way."""
        return self._target is not None

    def set_project(self, project: Project | None) -> None:
        """Work on another project, or on none."""
        self.stop()
        self._project = project

    def jump_to(self, number: int) -> None:
        """Let the edit of this number be the last one in effect; 0: take everything back."""
        if self._project is not None:
            self._target, self._count = number, 0
            self._timer.start()

    @Slot()
    def stop(self) -> None:
        """Stay where the jump has come to."""
        if self._target is not None:
            self._target = None
            self._timer.stop()
            self.arrived.emit()

    @Slot()
    def _go_on(self) -> None:
        clock = QElapsedTimer()
        clock.start()
        try:
            while self._target is not None and clock.elapsed() < _SLICE_MS:
                if not self._step(self._target):
                    self.stop()
                    return
                self._count += 1
        except InputError as error:
            self.stop()
            self.failed.emit(error)
            return
        if self._target is not None:
            self.moved.emit(self._count)

    def _step(self, target: int) -> bool:
        """Undo or redo one edit; False where the target is reached."""
        project = self._project
        if project is None:
            return False
        last = project.history.to_undo()
        if last is not None and last.number > target:
            return project.undo() is not None
        following = project.history.to_redo()
        if following is not None and following.number <= target:
            return project.redo() is not None
        return False
