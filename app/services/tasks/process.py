"""Work that lasts is done in a process of its own, so that the window always paints."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import Any

from PySide6.QtCore import QObject, Qt, Signal, Slot

from stereotrack_core.experiments.run_process import load
from stereotrack_core.worker_processes import (
    Asker,
    Done,
    Lost,
    WorkerProcess,
    call,
    end,
    with_words,
)

from .task import Threaded


class ProcessTask(QObject):
    """One piece of work in the process.

    Signals
    -------
    told : object
        What the work tells.
    ended : Exception or None
        It has come to its end, or failed; :class:`Lost` where the process has ended by itself.
    """

    told = Signal(object)
    ended = Signal(object)

    def __init__(self, work: Callable[[Asker], None], process: TaskProcess) -> None:
        super().__init__()
        self.work, self._process = work, process

    def order(self, word: Any) -> None:
        """Say something to the work; nothing happens once it has ended."""
        self._process.order(self, word)


class TaskProcess(QObject):
    """Does one task after the other, in a process that is started ahead of the first.

    Nothing here waits for the process: a thread listens to it. One that has ended by itself is
    started again for the tasks that are left.
    """

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._tasks: deque[ProcessTask] = deque()
        self._line: _Line | None = None

    def warm(self) -> None:
        """Start the process, and have it load what tracking needs."""
        if self._line is None:
            self._line = _Line(self._hear)
            self._give(ProcessTask(load, self))

    def run(self, work: Callable[[Asker], None]) -> ProcessTask:
        """Have something done, after what is being done; `work` is picklable and loads no Qt."""
        self.warm()
        task = ProcessTask(work, self)
        self._give(task)
        return task

    def order(self, task: ProcessTask, word: Any) -> None:
        """Say something to a task."""
        if task in self._tasks and self._line is not None:
            self._line.order(len(self._tasks) - self._tasks.index(task) - 1, word)

    def close(self) -> None:
        """End the process at once, with all that it does; waits for nothing."""
        line = self._line
        if line is not None:
            line.pass_on()
            line.close()
        self._line = None
        self._tasks.clear()

    def _give(self, task: ProcessTask) -> None:
        assert self._line is not None  # noqa: S101 - it is warm
        self._tasks.append(task)
        self._line.give(task.work)

    def _hear(self, line: _Line, words: list[Any]) -> None:
        for word in words:
            if line is not self._line:
                return
            if isinstance(word, Done | Exception):
                self._end(None if isinstance(word, Done) else word)
            else:
                self._tasks[0].told.emit(word)

    def _end(self, error: Exception | None) -> None:
        task = self._tasks.popleft()
        if isinstance(error, Lost):
            left, self._tasks, self._line = self._tasks, deque(), None
            for waiting in left:
                self.warm()
                self._give(waiting)
        task.ended.emit(error)


class _Line(Threaded):
    """A process and the thread that listens to it."""

    _heard = Signal()

    def __init__(self, hear: Callable[[_Line, list[Any]], None]) -> None:
        super().__init__(self._listen, "task process")
        self._heard.connect(self.pass_on, Qt.ConnectionType.QueuedConnection)
        self._hear = hear
        self._lock = threading.Lock()
        self._worker: WorkerProcess | None = None
        self._closed = False
        self._given = 0
        self._unsent: list[Callable[[WorkerProcess], None]] = []
        self._words: list[Any] = []
        self._begin()

    def give(self, work: Callable[[Asker], None]) -> None:
        """Have something done."""
        self._given += 1
        self._send(lambda worker: worker.give(work))

    def order(self, before: int, word: Any) -> None:
        """Say something to the task that was given so many tasks before the newest."""
        number = self._given - before
        self._send(lambda worker: worker.order(word, number))

    def close(self) -> None:
        """End the process."""
        with self._lock:
            self._closed = True
            if self._worker is not None:
                self._worker.terminate()

    def _send(self, send: Callable[[WorkerProcess], None]) -> None:
        with self._lock:
            if self._worker is None:
                self._unsent.append(send)
            else:
                send(self._worker)

    def _listen(self) -> None:
        """Start the process and wait for its words; in the thread."""
        worker = WorkerProcess(call, 1)
        try:
            with self._lock:
                self._worker = worker
                for send in self._unsent:
                    send(worker)
            while not self._closed:
                with_words([worker], None)
                self._put(list(worker.words()))
        except Lost as lost:
            self._put([lost])
        finally:
            end([worker])

    def _put(self, words: list[Any]) -> None:
        with self._lock:
            first = not self._words
            self._words += words
        if first and not self._closed:
            self._heard.emit()

    @Slot()
    def pass_on(self) -> None:
        """Pass on what the process has told since the last time."""
        with self._lock:
            words, self._words = self._words, []
        if not self._closed:
            self._hear(self, words)
