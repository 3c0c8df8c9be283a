"""Cyclic garbage is collected in the window's thread only.

A collection may run the destructor of a Qt object; were it set off by an allocation in a worker
thread, the object would be destroyed there while the window's thread still uses it.
"""

from __future__ import annotations

import gc
import sys

from PySide6.QtCore import QObject, QTimer

_MANY = 50
"""Modules that bring so many objects that a collection would take long."""


class GarbageTimer(QObject):
    """Switches the automatic collection off and collects from the event loop instead.

    Nothing that modules bring is looked at again, whether they are loaded already or later on:
    that took a fifth of a second each time.
    """

    def __init__(self, parent: QObject | None = None, milliseconds: int = 1000) -> None:
        super().__init__(parent)
        gc.disable()
        self._keep_modules()
        self._timer = QTimer(self)
        self._timer.timeout.connect(self._collect)
        self._timer.start(milliseconds)

    def _keep_modules(self) -> None:
        self._loaded = len(sys.modules)
        gc.freeze()

    def _collect(self) -> None:
        if len(sys.modules) > self._loaded + _MANY:
            self._keep_modules()
        counts = gc.get_count()
        thresholds = gc.get_threshold()
        for generation in (2, 1, 0):
            if thresholds[generation] and counts[generation] > thresholds[generation]:
                gc.collect(generation)
                return
