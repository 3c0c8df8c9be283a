"""Work off the window's thread: one kind of job, with progress, cancel and readable failures."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Hashable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, Generic, TypeVar

from stereotrack_core.compiled import load_before_threads
from stereotrack_core.counting import in_words
from stereotrack_core.errors import Cancelled
from stereotrack_core.work import Work
from stereotrack_core.worker_processes import ProcessTask, TaskProcess

from .messages import Loop
from .work_threads import WorkThread


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

    def __init__(
        self, job: Job, loop: Loop, changed: Callable[[], object], *, quiet: bool, promised: bool
    ) -> None:
        self.job, self._loop, self._changed = job, loop, changed
        self.quiet, self.promised, self.writes = quiet, promised, False
        self.token = CancelToken()
        self.over = False  # whether it has ended, or nobody waits for it any more
        self.share, self.words = 0.0, ""
        """Progress, 0 to 1 and 0 if unknown, and what is being done."""
        self._lock = threading.Lock()
        self._told: list[Any] = []
        self._progressed = False
        self._begun = time.monotonic()
        self._ended = threading.Event()
        self._ended.set()

    @property
    def work(self) -> Work:
        """What a long function is given; not kept, as a circle would keep all that is found."""
        return Work(self.report, self.token.cancelled)

    @property
    def title(self) -> str:
        return self.job.title

    @property
    def seconds(self) -> float:
        """Time since it was begun."""
        return time.monotonic() - self._begun

    def start(self, thread: WorkThread, ended: Callable[[Any, Exception | None], object]) -> None:
        """Do the work in a thread; `ended` gets result and error in the window's thread."""
        self._ended.clear()

        def run() -> None:
            result: Any = None
            error: Exception | None = Cancelled()
            try:
                result, error = self.job.work(self), None
            except Exception as problem:  # noqa: BLE001 - the window shows and logs it
                error = problem
            finally:
                self._loop.post(partial(ended, result, error))
                self._ended.set()

        load_before_threads()
        thread.do(self.title, run)

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
        return self._ended.wait(seconds)

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
        far = how_far(self.share, self.seconds) if self.seconds > _AT_ONCE_S else ""
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
        self._all: list[Task] = []
        self._later: list[tuple[bool, Callable[[], object]]] = []
        self._settled: list[Callable[[], bool]] = []
        self._idle: list[WorkThread] = []

    def watch(self, settled: Callable[[], bool]) -> None:
        """Ask this too whether everything that was asked for is done."""
        self._settled.append(settled)

    def settled(self) -> bool:
        """Whether everything that was asked for is done and shown."""
        return not self.tasks and all(settled() for settled in self._settled)

    @property
    def tasks(self) -> tuple[Task, ...]:
        return tuple(task for task in self._all if not task.quiet)

    def run(self, job: Job, *, promised: bool = False, quiet: bool = False) -> Task:
        """Start a job; one that is quiet is not listed, nor stopped by the person."""
        changed = _ignore if quiet else self._changed
        task = Task(job, self._loop, changed, quiet=quiet, promised=promised)
        if self._closed:
            task.give_up()
            return task
        self._all.append(task)
        thread = self._idle.pop() if self._idle else WorkThread(self._idle)
        task.start(thread, partial(self._on_ended, task))
        changed()
        return task

    def write(self, job: Job) -> Task:
        """Start a write to the project; writes are made one after the other, in their order."""
        before = next(reversed(self.promised()), None)

        def in_order(task: Task) -> Any:
            if before is not None:
                before.join()
            return job.work(task)

        task = self.run(replace(job, work=in_order), promised=True)
        task.writes = True
        return task

    def promised(self, *, exports: bool = False) -> tuple[Task, ...]:
        """Writes to the project that are under way, or all that is promised."""
        return tuple(one for one in self._all if one.writes or (exports and one.promised))

    def after_writes(self, do: Callable[[], object], *, exports: bool = False) -> None:
        """Call `do` as soon as all writes, or all that is promised, have ended."""
        if self.promised(exports=exports):
            self._later.append((exports, do))
        else:
            do()

    def finish_writes(self) -> None:
        """Wait for all writes to the project; for an end that cannot be put off."""
        for task in self.promised():
            task.join()

    def cancel_all(self) -> None:
        """Ask all work but writes to stop."""
        for task in self.tasks:
            if not task.writes:
                task.cancel()

    def shutdown(self, seconds: float = 10.0) -> None:
        """Stop all work and wait for it, all in all so long; what takes longer ends by itself.

        Writes to the project are waited for however long they take.
        """
        self._closed = True
        self.cancel_all()
        self.finish_writes()
        end = time.monotonic() + seconds
        for task in self.tasks:
            task.join(max(end - time.monotonic(), 0.0))
        for task in self._all:
            task.give_up()
        self._all.clear()

    def _on_ended(self, task: Task, result: Any, error: Exception | None) -> None:
        self._all = [kept for kept in self._all if kept is not task]
        task.end(result, error, self.failed)
        if self._closed:
            return
        if not task.quiet:
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


class LatestOnly:
    """Answers questions in the background, one at a time; of those that wait only the newest.

    `answer` leads from a question to its answer, in another thread, which has the `name`;
    `answered` and `failed` are called in this thread with a question and its answer or error.
    Those of a question that was overtaken while it was being answered are dropped, unless they
    are `late` and welcome all the same.
    """

    def __init__(
        self,
        tasks: TaskList,
        answer: Callable[[Any], Any],
        name: str,
        answered: Callable[[Any, Any], object],
        failed: Callable[[Any, Exception], object] | None = None,
        *,
        late: bool = False,
    ) -> None:
        self._late = late
        self._answer, self._name, self._answered = answer, name, answered
        self._failed = failed or (lambda _question, error: tasks.failed(error))
        self._asked: Hashable | None = None
        self._job = NewestJob(tasks, quiet=True)

    def settled(self) -> bool:
        """Whether the newest question is answered."""
        return self._asked is None

    def ask(self, question: Hashable) -> None:
        """Ask; a question that waits is not answered any more."""
        self._asked = question
        if not self._job.busy:
            self._begin(question)

    def close(self) -> None:
        """Forget what was asked, and what is being answered; returns at once."""
        self._asked = None
        self._job.give_up()

    def _begin(self, question: Hashable) -> None:
        answer, take = self._answer, partial(self._take, question)
        done, failed = partial(take, self._answered), partial(take, self._failed)
        stopped = partial(take, lambda *_: None, None)
        self._job.run(Job(self._name, lambda _task: answer(question), done, failed, stopped))

    def _take(self, question: Hashable, tell: Callable[..., object], found: Any) -> None:
        overtaken = question != self._asked
        if overtaken:
            self._begin(self._asked)
        else:
            self._asked = None
        if not overtaken or self._late:
            tell(question, found)


A = TypeVar("A")


class NewestAnswer(Generic[A]):
    """Asks in a thread of its own; the newest question wins.

    Until the new answer is there, the one before of the same frame holds, so that nothing flickers.
    `question` says what is to be asked now, about one ``frame``, or None; `changed` is called when
    another answer holds, or none. Errors are shown.
    """

    def __init__(
        self,
        tasks: TaskList,
        question: Callable[[], Any],
        answer: Callable[[Any], A],
        name: str,
        changed: Callable[[], object],
    ) -> None:
        self._question, self._changed, self._tell = question, changed, tasks.failed
        self._asked: Any = None
        self._answered: Any = None
        self.known: A | None = None  # the newest answer, be it about the frame before
        answers = self._on_answered, self._on_failed
        self._worker = LatestOnly(tasks, answer, name, *answers, late=True)

    def at(self, frame: int) -> A | None:
        """The answer about a frame, be it to the question before the newest; None without one."""
        there = self.known is not None and self._answered.frame == frame
        return self.known if there else None

    def settled(self) -> bool:
        """Whether what holds answers the newest question."""
        return self._asked is None or self._answered is self._asked

    def ask(self) -> None:
        self._asked = self._question()
        if self._asked is not None:
            self._worker.ask(self._asked)
        elif self.known is not None:
            self._answered = self.known = None
            self._changed()

    def close(self) -> None:
        """Forget everything, also what is still to be answered; the next question begins anew."""
        self._asked = self._answered = self.known = None
        self._worker.close()

    def _on_answered(self, question: Any, answer: A) -> None:
        if self._asked is not None and question.frame == self._asked.frame:
            self._answered, self.known = question, answer
            self._changed()

    def _on_failed(self, question: Any, error: Exception) -> None:
        if question is self._asked:
            self._asked = self._answered = self.known = None
            self._changed()
        self._tell(error)
