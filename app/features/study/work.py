"""The one thing that is done for a study at a time, in a thread."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from PySide6.QtCore import QObject, Signal

from ...services.tasks.task import Task, TaskList


class Work(QObject):
    """Begins tasks one at a time; reading gives way to anything else."""

    told = Signal(list)
    progressed = Signal(str, float)
    failed = Signal(object)
    ended = Signal(bool)
    """Whether it was reading."""

    def __init__(self, tasks: TaskList, parent: QObject) -> None:
        super().__init__(parent)
        self._tasks = tasks
        self._task: Task | None = None
        self._reads = False

    @property
    def busy(self) -> bool:
        """Whether something is tracked, looked for or written."""
        return self._task is not None and not self._reads

    @property
    def reading(self) -> bool:
        """Whether the study is being read."""
        return self._task is not None and self._reads

    def begin(
        self,
        title: str,
        work: Callable[[Task], Any],
        done: Callable[[Any], None],
        *,
        reads: bool = False,
    ) -> None:
        """Start `work`, and call `done` with its result; what was being read is left."""
        self.stop()
        task = Task(title, work)
        self._task, self._reads = task, reads
        task.told.connect(partial(self._if_wanted, task, self.told.emit))
        task.progressed.connect(partial(self._on_progress, task))
        task.finished.connect(partial(self._if_wanted, task, done))
        task.failed.connect(partial(self._if_wanted, task, self.failed.emit))
        task.ended.connect(partial(self._on_ended, task))
        self._tasks.start(task)

    def stop(self) -> None:
        """Ask the work to stop; what it has finished is kept."""
        if self._task is not None:
            self._task.cancel()

    def _if_wanted(self, task: Task, do: Callable[[Any], object], what: Any) -> None:
        if task is self._task:
            do(what)

    def _on_progress(self, task: Task, share: float, words: str) -> None:
        if task is self._task and not self._reads:
            self.progressed.emit(f"{task.title.capitalize()}: {words}", share)

    def _on_ended(self, task: Task) -> None:
        if task is self._task:
            self._task = None
            self.ended.emit(self._reads)
