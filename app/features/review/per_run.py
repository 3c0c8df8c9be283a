"""What is worked out in the background about each run, and again when the run has changed."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Generic, TypeVar
from weakref import WeakKeyDictionary

from PySide6.QtCore import QObject, Signal, Slot

from ...services.tasks.task import Task, TaskList

T = TypeVar("T")


class PerRun(QObject, Generic[T]):
    """Values of runs or references; one is worked out at a time, and a stop is not asked again."""

    changed = Signal()
    """Another value is known."""

    def __init__(self, tasks: TaskList, title: str) -> None:
        super().__init__(tasks)
        self._tasks, self._title = tasks, title
        self._asked: WeakKeyDictionary[object, Hashable] = WeakKeyDictionary()
        self._known: WeakKeyDictionary[object, tuple[Hashable, T]] = WeakKeyDictionary()
        self._task: Task | None = None
        self._about: object = None
        tasks.changed.connect(self._on_tasks)

    @property
    def busy(self) -> bool:
        """Whether something is being worked out."""
        return self._task is not None and self._task in self._tasks.tasks

    def asked(self, about: object) -> Hashable:
        """The state in which it was asked about last; None where it was not."""
        return self._asked.get(about)

    def of(self, about: object, state: Hashable = None) -> T | None:
        """What is known about a run in some state, or in any where none is given."""
        known = self._known.get(about)
        return known[1] if known is not None and state in (None, known[0]) else None

    def ask(self, about: object, state: Hashable, work: Callable[[Task], T]) -> None:
        """Work it out, unless that was asked before or something else is being worked out."""
        if self._asked.get(about) == state:
            return
        if self._task is not None:
            if about is self._about:
                self._task.cancel()  # what comes of it holds no longer
            return
        self._about, self._asked[about] = about, state

        def done(found: T) -> None:
            self._known[about] = state, found

        self._task = self._tasks.begin(self._title, work, done)

    @Slot()
    def _on_tasks(self) -> None:
        if self._task is not None and not self.busy:
            self._task = self._about = None
            self.changed.emit()
