"""Going to any place in the history by undo and redo."""

from __future__ import annotations

from PySide6.QtCore import QElapsedTimer, QObject, QTimer, Signal, Slot

from stereotrack_core.project.history import Entry

from ...session.edits import EditStack

_SLICE_MS = 25


class HistoryPresenter(QObject):
    """Undoes and redoes to any place in the history; the window stays alive meanwhile."""

    moved = Signal(int)
    """So many edits have been undone or redone since the jump began."""
    arrived = Signal()
    """The jump has ended: it is there, was stopped, or failed."""

    def __init__(self, edits: EditStack, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._edits = edits
        self._target: tuple[int, int] | None = None
        self._count = 0
        self._timer = QTimer(self, interval=0)
        self._timer.timeout.connect(self._go_on)

    @property
    def jumping(self) -> bool:
        """Whether a jump is under way."""
        return self._target is not None

    @Slot(object)
    def jump_to(self, entry: Entry | None) -> None:
        """Let this edit be the last one in effect; None: take everything back."""
        self._target, self._count = (0, 0) if entry is None else entry.order, 0
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
            if not self._step(self._target):
                self.stop()
                return
            self._count += 1
        if self._target is not None:
            self.moved.emit(self._count)

    def _step(self, target: tuple[int, int]) -> bool:
        """Undo or redo one edit; False where the target is reached, or nothing can be done."""
        last, following = self._edits.to_undo(), self._edits.to_redo()
        if last is not None and last.order > target:
            return self._edits.step(back=True) is not None
        if following is not None and following.order <= target:
            return self._edits.step(back=False) is not None
        return False
