"""What is to be drawn again, one piece at a time, so that the window answers in between."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from pyqtgraph.Qt import isQObjectAlive
from PySide6.QtCore import QObject, QTimer, Slot

Piece: TypeAlias = Callable[[], None]
"""A method of an object; nothing is drawn of a Qt object that is gone."""


class RedrawQueue(QObject):
    """Draws one piece in each round of the event loop: keys and mouse wait for one at most.

    A piece that is asked for again before its turn keeps its place and is drawn once, as things
    are then. So what changes often cannot fall behind, and holds up nothing else.
    """

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._waiting: dict[Piece, None] = {}
        self._timer = QTimer(self, interval=0)
        self._timer.timeout.connect(self._draw_one)

    def soon(self, piece: Piece) -> None:
        """Draw a piece when it is its turn."""
        self._waiting[piece] = None
        self._timer.start()

    def settled(self) -> bool:
        """Whether everything that was asked for is drawn."""
        return not self._waiting

    @Slot()
    def _draw_one(self) -> None:
        piece = next(iter(self._waiting))
        del self._waiting[piece]
        if not self._waiting:
            self._timer.stop()
        owner = getattr(piece, "__self__", None)
        if not isinstance(owner, QObject) or isQObjectAlive(owner):
            piece()
