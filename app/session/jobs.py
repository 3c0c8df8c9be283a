"""Work off the window's thread: one kind of job, with progress, cancel and readable failures."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from stereotrack_core.compiled import load_before_threads
from stereotrack_core.counting import in_words
from stereotrack_core.errors import Cancelled
from stereotrack_core.worker_processes import ProcessTask, TaskProcess

from .surroundings import Loop


class WorkThread(threading.Thread):
    """A thread of the window's; the program does not wait for it for ever."""


def wait_for_threads(seconds: float) -> None:
    """Let the window's threads end that were told to; called when nobody looks any more."""
    end = time.monotonic() + seconds
    for thread in threading.enumerate():
        if isinstance(thread, WorkThread):
            thread.join(max(end - time.monotonic(), 0.0))


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


def _ignore(*_news: object) -> None:
    return


@dataclass(frozen=True, eq=False)
class Job:
    """Work for a thread of its own, and who is told of it, always in the window's thread."""

    title: str  # what is being done, for the status line
    work: Callable[[Task], Any]
    """Called with the task: it reports by :meth:`Task.report`, hands on interim results by
    :meth:`Task.tell`, and looks at ``task.token``."""
    done: Callable[[Any], object] = _ignore
    failed: Callable[[Exception], object] | None = None  # None: a message says why
    stopped: Callable[[], object] = _ignore
    ended: Callable[[], object] = _ignore  # after one of these three
    told: Callable[[list[Any]], object] = _ignore  # with all that was told since the last time
    progressed: Callable[[float, str], object] = _ignore
    discard: Callable[[Any], object] = _ignore  # closes a result that comes too late


class Task:
    """A job under way, or over; `changed` is called when it has said how far it is."""

    def __init__(self, job: Job, loop: Loop, changed: Callable[[], object]) -> None:
        self.job, self._loop, self._changed = job, loop, changed
        self.token = CancelToken()
        self.over = False
        """Whether it has ended, or nobody waits for it any more."""
        self.share, self.words = 0.0, ""
        """Progress, 0 to 1 and 0 if unknown, and what is being done."""
        self._lock = threading.Lock()
        self._told: list[Any] = []
        self._progressed = False
        self._begun = time.monotonic()
        self._thread: WorkThread | None = None

    @property
    def title(self) -> str:
        return self.job.title

    def start(self, ended: Callable[[Any, Exception | None], object]) -> None:
        """Do the work in a thread; `ended` gets result and error in the window's thread."""

        def run() -> None:
            result: Any = None
            error: Exception | None = Cancelled()
            try:
                result, error = self.job.work(self), None
            except Exception as problem:  # noqa: BLE001 - the window shows and logs it
                error = problem
            finally:
                self._loop.post(partial(ended, result, error))

        load_before_threads()
        self._thread = WorkThread(target=run, name=self.title, daemon=True)
        self._thread.start()

    def end(
        self, result: Any, error: Exception | None, failed: Callable[[Exception], object]
    ) -> None:
        """Tell how it ended; a result that nobody waits for is discarded."""
        call, job = self._loop.call, self.job
        if self.over:
            if error is None:
                call(job.discard, result)
            return
        self.over = True
        if error is None:
            call(job.done, result)
        elif isinstance(error, Cancelled):
            call(job.stopped)
        else:
            call(job.failed or failed, error)
        call(job.ended)

    def cancel(self) -> None:
        """Ask the work to stop; how it ends is told."""
        self.token.cancel()

    def give_up(self) -> None:
        """Ask the work to stop; nothing that comes of it is told."""
        self.token.cancel()
        self.over = True

    def join(self, seconds: float | None = None) -> bool:
        """Wait for the end of the work, for at most so long; False where it still runs."""
        if self._thread is not None:
            self._thread.join(seconds)
        return self._thread is None or not self._thread.is_alive()

    def report(self, share: float, words: str = "") -> None:
        """Say how far the work is (0: nobody knows, to 1); may be called from any thread."""
        with self._lock:
            first, self._progressed = not self._progressed, True
            self.share, self.words = share, words
        if first:
            self._loop.post(self._pass_on)

    def tell(self, word: Any) -> None:
        """Tell something, from any thread; the window hears all since the last time at once."""
        with self._lock:
            self._told.append(word)
            first = len(self._told) == 1
        if first:
            self._loop.post(self._pass_on)

    def in_process(self, process: TaskProcess, todo: ProcessTask) -> Any:
        """Have it done in another process; what that tells is told here."""
        return process(todo, self.tell, self.token.cancelled)

    def says(self) -> str:
        """What is being done: ``Writing report, reading images, 40 %, about 3 s left``."""
        seconds = time.monotonic() - self._begun
        far = how_far(self.share, seconds) if seconds > _AT_ONCE_S else ""
        return ", ".join(part for part in (self.title, self.words, far) if part)

    def _pass_on(self) -> None:
        with self._lock:
            words, self._told = self._told, []
            progressed, self._progressed = self._progressed, False
        if self.over:
            return
        if words:
            self._loop.call(self.job.told, words)
        if progressed:
            self._loop.call(self.job.progressed, self.share, self.words)
            self._changed()


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


class TaskList:
    """Runs jobs, and stops them when the window closes; nobody is told of a late answer then.

    What is promised (writes to the project, exports) was told to the person as done or under way:
    closing the window waits for it, and leaving the project waits for the writes to it.

    `failed` shows an error, `changed` is called when :attr:`tasks` or their progress has changed.
    """

    def __init__(
        self, loop: Loop, failed: Callable[[Exception], object], changed: Callable[[], object]
    ) -> None:
        self._loop, self.failed, self._changed = loop, failed, changed
        self._closed = False
        self._quiet: list[Task] = []
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
        done: Callable[[Any], object] = _ignore,
        failed: Callable[[Exception], object] | None = None,
        *,
        promised: bool = False,
    ) -> Task:
        """Start `work`; call `done` with its result, or `failed` with its error, in this thread."""
        return self.run(Job(title, work, done, failed), promised=promised)

    def run(self, job: Job, *, promised: bool = False, quiet: bool = False) -> Task:
        """Start a job; one that is quiet is not listed, nor stopped by the person."""
        task = Task(job, self._loop, _ignore if quiet else self._changed)
        if self._closed:
            task.give_up()
            return task
        if promised:
            self._promised.append(task)
        (self._quiet if quiet else self._tasks).append(task)
        task.start(partial(self._on_ended, task))
        if not quiet:
            self._changed()
        return task

    def write(self, job: Job) -> Task:
        """Start a write to the project; writes are made one after the other, in their order."""
        before = self._writes[-1] if self._writes else None

        def in_order(task: Task) -> Any:
            if before is not None:
                before.join()
            return job.work(task)

        task = self.run(replace(job, work=in_order), promised=True)
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
        """Wait for all writes to the project; for an end that cannot be put off."""
        for task in tuple(self._writes):
            task.join()

    def cancel_all(self) -> None:
        """Ask all work but writes to stop."""
        for task in self._tasks:
            if task not in self._writes:
                task.cancel()

    def shutdown(self, seconds: float = 10.0) -> None:
        """Stop all work and wait for it, all in all so long; what takes longer ends by itself.

        Writes to the project are waited for however long they take.
        """
        self._closed = True
        self.cancel_all()
        self.finish_writes()
        end = time.monotonic() + seconds
        for task in self._tasks:
            task.join(max(end - time.monotonic(), 0.0))
        for task in (*self._tasks, *self._quiet):
            task.give_up()
        for tasks in self._lists():
            tasks.clear()

    def _lists(self) -> tuple[list[Task], ...]:
        return self._quiet, self._tasks, self._promised, self._writes

    def _on_ended(self, task: Task, result: Any, error: Exception | None) -> None:
        task.join()  # it has said its last word
        for tasks in self._lists():
            tasks[:] = [kept for kept in tasks if kept is not task]
        task.end(result, error, self.failed)
        if self._closed:
            return
        self._changed()
        later, self._later = self._later, []
        for exports, do in later:
            self.after_writes(do, exports=exports)


class NewestJob:
    """Has the newest job of a kind done: another one takes its place, and nobody hears of it."""

    def __init__(self, tasks: TaskList, *, quiet: bool = False) -> None:
        self._tasks, self._quiet = tasks, quiet
        self.task: Task | None = None

    @property
    def busy(self) -> bool:
        return self.task is not None and not self.task.over

    def run(self, job: Job, *, promised: bool = False) -> Task:
        self.give_up()
        self.task = self._tasks.run(job, promised=promised, quiet=self._quiet)
        return self.task

    def cancel(self) -> None:
        """Ask it to stop; how it ends is told."""
        if self.task is not None:
            self.task.cancel()

    def give_up(self) -> None:
        """Do without it; nothing that comes of it is told."""
        if self.task is not None:
            self.task.give_up()
            self.task = None
