"""When pieces are drawn and calls are made, so that the window answers; who gets a key."""

from collections.abc import Callable

from PySide6.QtCore import QEvent, QObject, QTimer, Slot
from PySide6.QtGui import QKeyEvent


def takes_key(event: QEvent, wants: Callable[[QKeyEvent], bool]) -> bool:
    """Whether a widget `wants` the key of an event, which is no command's shortcut then."""
    asks = event.type() == QEvent.Type.ShortcutOverride
    if not asks or not isinstance(event, QKeyEvent) or not wants(event):
        return False
    event.accept()
    return True


def later(owner: QObject, do: Callable[[], object], milliseconds: int = 0) -> QTimer:
    """Timer that calls `do` once, so long after it was started last."""
    timer = QTimer(owner, singleShot=True, interval=milliseconds)
    timer.timeout.connect(do)
    return timer


def is_alive(do: Callable[..., object]) -> bool:
    """Whether a function can be called: it is no method of a Qt object that is gone."""
    owner = getattr(do, "__self__", None)
    if isinstance(owner, QObject):
        try:
            owner.objectName()
        except RuntimeError:
            return False
    return True


class RedrawQueue(QObject):
    """Draws one piece in each round of the event loop: keys and mouse wait for one at most.

    A piece that is asked for again before its turn keeps its place and is drawn once, as things
    are then. So what changes often cannot fall behind, and holds up nothing else. Nothing is drawn
    by a method of a Qt object that is gone.
    """

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._waiting: dict[Callable[[], object], None] = {}
        self._timer = QTimer(self, interval=0)
        self._timer.timeout.connect(self._draw_one)

    def soon(self, piece: Callable[[], object]) -> None:
        self._waiting[piece] = None
        self._timer.start()

    def settled(self) -> bool:
        return not self._waiting

    @Slot()
    def _draw_one(self) -> None:
        piece = next(iter(self._waiting))
        del self._waiting[piece]
        if not self._waiting:
            self._timer.stop()
        if is_alive(piece):
            piece()
