"""Going to any place in the project's history by undo and redo."""

from __future__ import annotations

from PySide6.QtCore import QElapsedTimer, QObject, QTimer, Signal, Slot

from stereotrack_core.errors import InputError
from stereotrack_core.project.history import Changed, Entry
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

    def set_project(self, project: Project | None) -> None:
        """Go through another project's history from now on."""
        self.stop()
        self._project = project

    @property
    def jumping(self) -> bool:
        """Whether a jump is under way."""
        return self._target is not None

    @Slot(object)
    def jump_to(self, entry: Entry | None) -> None:
        """Let this edit be the last one in effect; None: take everything back."""
        self._target, self._count = 0 if entry is None else entry.number, 0
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
        while self._target is not None and clock.elapsed() < _SLICE_MS:
            try:
                there = self._step(self._target) is None
            except InputError as error:
                self.failed.emit(error)
                there = True
            if there:
                self.stop()
                return
            self._count += 1
        if self._target is not None:
            self.moved.emit(self._count)

    def _step(self, target: int) -> Changed | None:
        """Undo or redo one edit; None where the target is reached, or nothing can be done."""
        project = self._project
        if project is None:
            return None
        last, following = project.history.to_undo(), project.history.to_redo()
        if last is not None and last.number > target:
            return project.undo()
        if following is not None and following.number <= target:
            return project.redo()
        return None
