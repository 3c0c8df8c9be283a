"""Qt objects with a thread of their own, which are destroyed in the window's thread."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from functools import partial

from PySide6.QtCore import QObject, Qt, Signal, Slot


class WorkThread(threading.Thread):
    """A thread of the window's; the program does not wait for it for ever."""

    def __init__(self, target: Callable[[], object], name: str) -> None:
        super().__init__(target=target, name=name, daemon=True)


class Threaded(QObject):
    """Works in a thread of its own, from when a subclass calls :meth:`_begin`.

    The thread refers to the object as long as it runs. Were that the last reference, Qt's part
    would be destroyed in that thread, while the window's may be about to deliver something to it.
    So the object holds itself from the beginning, and lets go in the window's thread, when that
    thread knows that the other one has ended.

    Parameters
    ----------
    work : callable
        What is done in the thread.
    name : str
        Name of the thread.
    """

    _left = Signal()

    def __init__(self, work: Callable[[], object], name: str) -> None:
        super().__init__()
        self._left.connect(self._let_go, Qt.ConnectionType.QueuedConnection)
        self._thread = WorkThread(partial(self._live, work), name)
        self._itself: Threaded | None = None

    def _begin(self) -> None:
        self._itself = self
        self._thread.start()

    def _live(self, work: Callable[[], object]) -> None:
        try:
            work()
        finally:
            self._left.emit()

    @Slot()
    def _let_go(self) -> None:
        self._thread.join()  # it has said its last word
        self._itself = None


def wait_for_threads(seconds: float) -> None:
    """Let the window's threads end that were told to; called when nobody looks any more."""
    end = time.monotonic() + seconds
    for thread in threading.enumerate():
        if isinstance(thread, WorkThread):
            thread.join(max(end - time.monotonic(), 0.0))
