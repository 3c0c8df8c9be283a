"""Makes the clouds of the stretch before anything is tried, so that the first attempt has them."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable

from PySide6.QtCore import QObject, QTimer, Slot

from stereotrack_core.errors import Cancelled
from stereotrack_core.tracking.tuning.attempt import Attempt, colours
from stereotrack_core.tracking.tuning.clouds import CloudStore

from .stores import StoreKeeper

_PAUSE_MS = 400


class CloudWarmer(QObject):
    """Works in a thread of its own while nobody else needs the clouds.

    Parameters
    ----------
    stores : StoreKeeper
    wanted : callable
        What would be tried now; None where nothing is to be made.
    """

    def __init__(self, stores: StoreKeeper, wanted: Callable[[], Attempt | None]) -> None:
        super().__init__()
        self._stores, self._wanted = stores, wanted
        self._thread: threading.Thread | None = None
        self._cancelled = threading.Event()
        self._pause = QTimer(self, singleShot=True, interval=_PAUSE_MS)
        self._pause.timeout.connect(self._begin)

    @Slot()
    def warm_soon(self, _what: object = None) -> None:
        """Make the clouds when nothing has changed for a moment."""
        self.cancel()
        self._pause.start()

    def cancel(self) -> None:
        """Let others have the clouds; returns at once, and what is made is kept."""
        self._pause.stop()
        self._cancelled.set()

    def stop(self) -> None:
        """End, and wait for the thread."""
        self.cancel()
        if self._thread is not None:
            self._thread.join(15.0)
            self._thread = None

    @Slot()
    def _begin(self) -> None:
        attempt, store = self._wanted(), self._stores.store()
        if attempt is None or store is None:
            return
        cancelled = self._cancelled = threading.Event()
        self._thread = threading.Thread(
            target=_make, args=(attempt, store, cancelled.is_set), name="attempt", daemon=True
        )
        self._thread.start()


def _make(attempt: Attempt, store: CloudStore, cancelled: Callable[[], bool]) -> None:
    try:
        clouds = store.clouds(
            attempt.key(colour=colours(attempt, store)), attempt.stretch, cancelled
        )
        for frame in attempt.stretch:
            clouds.take(frame)
    except Cancelled:
        pass  # an attempt makes what is missing itself
    except Exception:  # whoever tries the stretch meets the same, and tells the person
        logging.getLogger(__name__).exception("clouds could not be made beforehand")
