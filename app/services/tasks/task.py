"""Work off the window's thread, with progress, cancel and readable failures."""

from __future__ import annotations

import gc
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from PySide6.QtCore import QObject, Qt, QTimer, Signal, Slot

from stereotrack_core.compiled import load_before_threads
from stereotrack_core.counting import in_words
from stereotrack_core.errors import Cancelled
from stereotrack_core.worker_processes import TaskProcess


class WorkThread(threading.Thread):
    """A thread of the window's; the program does not wait for it for ever."""


def wait_for_threads(seconds: float) -> None:
    """Let the window's threads end that were told to; called when nobody looks any more."""
    end = time.monotonic() + seconds
    for thread in threading.enumerate():
        if isinstance(thread, WorkThread):
            thread.join(max(end - time.monotonic(), 0.0))


_MANY = 50  # modules that bring so many objects that a collection would take long


class GarbageTimer(QObject):
    """Switches the automatic collection off and collects from the event loop instead.

    A collection may run the destructor of a Qt object; were it set off by an allocation in a worker
    thread, the object would be destroyed there while the window's thread still uses it.

    Nothing that modules bring is looked at again, whether they are loaded already or later on:
    that took a fifth of a second each time.
    """

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        gc.disable()
        self._keep_modules()
        self._timer = QTimer(self, interval=1000)
        self._timer.timeout.connect(self._collect)
        self._timer.start()

    def _keep_modules(self) -> None:
        self._loaded = len(sys.modules)
        gc.freeze()

    def _collect(self) -> None:
        if len(sys.modules) > self._loaded + _MANY:
            self._keep_modules()
        counts, limits = gc.get_count(), gc.get_threshold()
        due = [k for k in range(3) if limits[k] and counts[k] > limits[k]]
        if due:
            gc.collect(due[-1])


class CancelToken(threading.Event):
    """Tells work in another thread that it is no longer wanted."""

    cancel, cancelled = threading.Event.set, threading.Event.is_set


_FIRST_GUESS = 0.05  # share of the work that has to be done before its end is estimated
_AT_ONCE_S = 1.0  # what takes less is over before anybody has read how far it is


def how_far(share: float, seconds: float) -> str:
    """``40 %, about 3 s left``, of work that has taken so many seconds; empty while unknown."""
    if not _FIRST_GUESS <= share < 1.0:
        return ""
    return f"{100.0 * share:.0f} %, {time_left(seconds * (1.0 - share) / share)}"


def time_left(seconds: float) -> str:
    """``about 3 s left``, ``under a second left``."""
    return f"{'' if seconds < 1.0 else 'about '}{in_words(seconds)} left"


class Task(QObject):
    """One piece of work in a thread of its own; all work of the window is done by tasks.

    Signals are sent in the thread that made the task, from its event loop: whoever connects to
    them right after the start misses none, however quickly the work is done.

    The thread refers to the task as long as it runs. Were that the last reference, Qt's part would
    be destroyed in that thread, while the window's may be about to deliver something to it. So a
    task holds itself from its start until the window's thread hears that the work is over.

    `title` says in the status line what is being done. `work` is called with the task; it reports
    by :meth:`report`, hands on interim results by :meth:`tell`, and looks at ``task.token``.
    """

    progressed = Signal(float, str)
    finished = Signal(object)
    failed = Signal(object)
    stopped = Signal()
    ended = Signal()
    told = Signal(list)
    _over = Signal(object)
    _heard = Signal()

    def __init__(self, title: str, work: Callable[[Task], Any]) -> None:
        super().__init__()
        self._thread = WorkThread(target=self._run, name=title, daemon=True)
        self._itself: Task | None = None
        self._over.connect(self._tell, Qt.ConnectionType.QueuedConnection)
        self._heard.connect(self._pass_on, Qt.ConnectionType.QueuedConnection)
        self.title = title
        self.token = CancelToken()
        self.error: Exception | None = None
        """Why it failed; :class:`Cancelled` if it was stopped."""
        self.result: Any = None
        self._lock = threading.Lock()
        self._waiting: list[Any] = []
        self.share = 0.0
        """Progress, 0 to 1; 0 if unknown."""
        self.words = ""
        self._work = work
        self._given_up = False
        self._begun = time.monotonic()

    def start(self) -> None:
        self._begun = time.monotonic()
        self._itself = self
        load_before_threads()
        self._thread.start()

    def cancel(self) -> None:
        self.token.cancel()

    def give_up(self) -> None:
        """Ask the work to stop, and tell nobody how it ends."""
        self.cancel()
        self._given_up = True

    def join(self, seconds: float | None = None) -> bool:
        """Wait for the end of the work, for at most so long; False where it still runs."""
        if self._thread.ident is not None:
            self._thread.join(seconds)
        return not self._thread.is_alive()

    def report(self, share: float, words: str = "") -> None:
        """Say how far the work is (0: nobody knows, to 1); may be called from any thread."""
        self.share, self.words = share, words
        self.progressed.emit(share, words)

    def tell(self, word: Any) -> None:
        """Tell something, from any thread; ``told`` brings the window all since the last time."""
        with self._lock:
            self._waiting.append(word)
            first = len(self._waiting) == 1
        if first:
            self._heard.emit()

    def says(self) -> str:
        """What is being done: ``Writing report, reading images, 40 %, about 3 s left``."""
        seconds = time.monotonic() - self._begun
        far = how_far(self.share, seconds) if seconds > _AT_ONCE_S else ""
        return ", ".join(part for part in (self.title, self.words, far) if part)

    def _run(self) -> None:
        error: BaseException | None = Cancelled()
        try:
            self.result, error = self._work(self), None
        except Exception as problem:  # noqa: BLE001 - handed to the window, which shows and logs it
            error = problem
        finally:
            self._over.emit(error)

    @Slot()
    def _pass_on(self) -> None:
        with self._lock:
            words, self._waiting = self._waiting, []
        if not self._given_up:
            self.told.emit(words)

    @Slot(object)
    def _tell(self, error: Exception | None) -> None:
        self._thread.join()  # it has said its last word
        self._itself = None
        if self._given_up:
            return
        self.error = error
        if error is None:
            self.finished.emit(self.result)
        elif isinstance(error, Cancelled):
            self.stopped.emit()
        else:
            self.failed.emit(error)
        self.ended.emit()


@dataclass(frozen=True, eq=False)
class Processes:
    """Processes that work for windows, one after the other."""

    run: TaskProcess = field(default_factory=TaskProcess)
    """Tracks the run in progress, which may be held for as long as a person likes."""
    trials: TaskProcess = field(default_factory=TaskProcess)
    """Tracks trials and records what single steps did; keeps the clouds for them."""
    calibration: TaskProcess = field(default_factory=TaskProcess)

    def close(self) -> None:
        for process in (self.run, self.trials, self.calibration):
            process.close()


class TaskList(QObject):
    """All work that is under way; keeps tasks alive and stops them when the window closes.

    What is promised (writes to the project, exports) was told to the person as done or under way:
    closing the window waits for it, and leaving the project waits for the writes to it.
    """

    changed = Signal()

    def __init__(
        self, failed: Callable[[Exception], object], parent: QObject | None = None
    ) -> None:
        super().__init__(parent)
        self.failed = failed
        self._tasks: list[Task] = []
        self._promised: list[Task] = []
        self._writes: list[Task] = []
        self._later: list[tuple[bool, Callable[[], object]]] = []
        self._settled: list[Callable[[], bool]] = []

    def watch(self, settled: Callable[[], bool]) -> None:
        """Ask this too whether everything that was asked for is done."""
        self._settled.append(settled)

    def settled(self) -> bool:
        """Whether everything that was asked for is done and shown."""
        return not self._tasks and all(settled() for settled in self._settled)

    @property
    def tasks(self) -> tuple[Task, ...]:
        return tuple(self._tasks)

    def begin(
        self,
        title: str,
        work: Callable[[Task], Any],
        done: Callable[[Any], None] | None = None,
        failed: Callable[[Exception], None] | None = None,
        *,
        promised: bool = False,
    ) -> Task:
        """Start `work`; call `done` with its result, or `failed` with its error, in this thread."""
        task = Task(title, work)
        if promised:
            self._promised.append(task)
        if done is not None:
            task.finished.connect(done)
        task.failed.connect(failed or self.failed)
        self.start(task)
        return task

    def write(
        self, title: str, work: Callable[[Task], Any], done: Callable[[Any], None] | None = None
    ) -> Task:
        """Start a write to the project; writes are made one after the other, in their order."""
        before = self._writes[-1] if self._writes else None

        def in_order(task: Task) -> Any:
            if before is not None:
                before.join()
            return work(task)

        task = self.begin(title, in_order, done, promised=True)
        self._writes.append(task)
        return task

    def promised(self, *, exports: bool = False) -> tuple[Task, ...]:
        """Writes to the project that are under way, or all that is promised."""
        return tuple(self._promised if exports else self._writes)

    def after_writes(self, do: Callable[[], object], *, exports: bool = False) -> None:
        """Call `do` as soon as all writes, or all that is promised, have ended."""
        if self.promised(exports=exports):
            self._later.append((exports, do))
        else:
            do()

    def finish_writes(self) -> None:
        """Wait for all writes to the project, in this thread; for an end that cannot be put off."""
        for task in self._writes:
            task.join()

    def start(self, task: Task) -> None:
        """Start a task whose failure is told by whoever made it."""
        task.progressed.connect(self.changed)
        task.ended.connect(self._on_ended)
        self._tasks.append(task)
        task.start()
        self.changed.emit()

    def cancel_all(self) -> None:
        """Ask all work but writes to stop."""
        for task in self._tasks:
            if task not in self._writes:
                task.cancel()

    def shutdown(self, seconds: float = 10.0) -> None:
        """Stop all work and wait for it, all in all so long; what takes longer ends by itself.

        Writes to the project are waited for however long they take.
        """
        self.cancel_all()
        self.finish_writes()
        end = time.monotonic() + seconds
        for task in tuple(self._tasks):
            if not task.join(max(end - time.monotonic(), 0.0)):
                task.give_up()
        for tasks in (self._tasks, self._promised, self._writes):
            tasks.clear()

    @Slot()
    def _on_ended(self) -> None:
        task = self.sender()
        for tasks in (self._tasks, self._promised, self._writes):
            tasks[:] = [kept for kept in tasks if kept is not task]
        self.changed.emit()
        later, self._later = self._later, []
        for exports, do in later:
            self.after_writes(do, exports=exports)
