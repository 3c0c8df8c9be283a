"""Processes of this machine that do one task after the other, each on its share of the cores.

Unlike :class:`concurrent.futures.ProcessPoolExecutor` they can be ended at any moment, tell how
far they are, and one of them that is killed takes no other with it. They never outlive the one
that has started them.
"""

import multiprocessing
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from types import ModuleType
from typing import Any, TypeAlias
from weakref import WeakKeyDictionary

import cv2

from stereotrack_core.errors import Cancelled, portable
from stereotrack_core.one_thread import one_blas_thread

_TELL_SECONDS = 0.2
_LAST_WORD_SECONDS = 5.0
_LOOK_SECONDS = 0.1
_NICE = 15
_CONTEXT = multiprocessing.get_context("spawn")
_STARTING = threading.Lock()
"""Held while a process is started, which inherits variables that are set for it."""


@dataclass(frozen=True)
class Stop:
    """The order to end a task that is no longer wanted."""


class Asker:
    """Whoever wants a task done, as the process at work knows it; `kept` is for later tasks."""

    def __init__(self, pipe: Connection) -> None:
        self.kept: dict[str, Any] = {}
        self._pipe = pipe
        self._listening = threading.Lock()
        self._stopped = False
        self._untold = 0
        self._told = 0.0

    def on_frames(self, count: int) -> None:
        """So many frames more are done; the number is told some times a second."""
        self._untold += count
        if time.monotonic() - self._told > _TELL_SECONDS:
            self._tell_frames()

    def tell(self, word: Any) -> None:
        """Tell something that is no number; numbers that wait go first."""
        self._tell_frames()
        self._pipe.send(word)

    def orders(self, seconds: float | None = 0.0) -> list[Any]:
        """What was said about the task in work since the last call.

        Waits for the first so long at most; None: until there is one.

        Raises EOFError where whoever asks is gone, Cancelled where the task is no longer wanted.
        """
        found: list[Any] = []
        with self._listening:
            while not self._stopped and self._pipe.poll(0.0 if found else seconds):
                _, word = self._pipe.recv()
                self._stopped |= isinstance(word, Stop)
                found.append(word)
        if self._stopped:
            raise Cancelled
        return found

    def cancelled(self) -> bool:
        """Whether the task in work is no longer wanted; may be asked by several threads."""
        try:
            self.orders()
        except Cancelled:
            return True
        return False

    def next_task(self) -> Any:
        """Wait for the next task; what is still said about the one before is left out."""
        while True:
            is_order, word = self._pipe.recv()
            if not is_order:
                self._stopped = False
                return word

    def _tell_frames(self) -> None:
        if self._untold:
            self._pipe.send(self._untold)
            self._untold, self._told = 0, time.monotonic()


ProcessTask: TypeAlias = Callable[[Asker], Any]
"""Picklable; called in the process, it returns its result, tells what it has to and hears orders
from the :class:`Asker`."""


class Lost(Exception):
    """A process has ended by itself, with an exit code, in the middle of a task."""

    def __init__(self, code: int | None) -> None:
        super().__init__(f"the process at work ended unexpectedly (exit code {code})")
        self.code = code if code is not None else 1


@dataclass(frozen=True)
class _Done:
    """The last word of a task that has not failed."""

    result: Any


class _Worker:
    """A process that waits for tasks, with its share of the machine's cores."""

    def __init__(self, count: int, nice: int) -> None:
        self.pipe, theirs = _CONTEXT.Pipe()
        threads = max(1, usable_cores() // count)
        self.process = _CONTEXT.Process(target=_serve, args=(theirs, threads, nice), daemon=True)
        libraries = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
        limits = {**dict.fromkeys(libraries, "1"), "NUMBA_NUM_THREADS": str(threads)}
        with _STARTING, _environment(limits), _without_main(), _out_of_reach_of_interrupts():
            self.process.start()
        theirs.close()

    def send(self, word: Any, *, is_order: bool = True) -> None:
        """Give it a task, or say something about the one in work; see :meth:`Asker.orders`."""
        with suppress(BrokenPipeError, ConnectionResetError):  # found out by listening to it
            self.pipe.send((is_order, word))

    def word(self) -> Any:
        """Receive the next message. Raises :class:`Lost` if the process has ended."""
        try:
            return self.pipe.recv()
        except (EOFError, OSError):  # the latter in the middle of a word
            self.process.join(_LAST_WORD_SECONDS)
            raise Lost(self.process.exitcode) from None

    def end(self) -> None:
        """End it at once; what it is at is lost."""
        self.process.terminate()
        self.process.join(_LAST_WORD_SECONDS)
        if self.process.is_alive():
            self.process.kill()
            self.process.join()
        self.pipe.close()


class TaskProcess:
    """Started with its first task, it does one after the other; threads wait for theirs.

    `count` processes share the machine's cores. `nice`: how far it stands back; by default who
    paints goes first.
    """

    def __init__(self, count: int = 1, *, nice: int = _NICE) -> None:
        self._count, self._nice = count, nice
        self._lock, self._turn = threading.Lock(), threading.Lock()
        self._worker: _Worker | None = None
        self._in_work: ProcessTask | None = None
        self._orders: WeakKeyDictionary[ProcessTask, list[Any]] = WeakKeyDictionary()
        self._heard = self._closed = False

    def __call__(
        self,
        task: ProcessTask,
        hear: Callable[[Any], None] = lambda _: None,
        cancelled: Callable[[], bool] = lambda: False,
        *,
        listens: bool = True,
    ) -> Any:
        """Have a task done, when those before are; what it returns.

        `hear` is called with each word that the task tells, `cancelled` asked some times a second
        whether it is still wanted. A task that `listens` looks at its orders; otherwise the process
        is ended to cancel it. One that has ended before it has told anything is started anew, once.

        Raises what the task raised; Cancelled where it is no longer wanted, or the process is
        closed; Lost where the process has ended by itself.
        """

        def unwanted() -> bool:
            return self._closed or cancelled()

        with self._turn:
            self._heard = again = False
            while not unwanted():
                worker = self._given(task)
                try:
                    return self._result(worker, hear, unwanted, listens=listens)
                except Lost:
                    if not unwanted() and (again or self._heard):
                        raise
                    again = True
            if self._closed:  # it may have been started just now
                self._drop()
        raise Cancelled

    @property
    def pid(self) -> int | None:
        """Number of the process; None where none is running."""
        return None if self._worker is None else self._worker.process.pid

    def order(self, task: ProcessTask, word: Any) -> None:
        """Say something about a task that is in work, or waits for its turn."""
        with self._lock:
            self._orders.setdefault(task, []).append(word)
            if task is self._in_work and self._worker is not None:
                self._worker.send(word)

    def end(self) -> None:
        """End the process at once, with the task in work; the next task starts another one."""
        with self._lock:
            if self._worker is not None:
                self._worker.process.terminate()
        if self._turn.acquire(blocking=False):  # no thread is there that would find it out
            self._drop()
            self._turn.release()

    def close(self) -> None:
        """End the process for good; whoever waits for it gets :class:`Cancelled`."""
        self._closed = True
        self.end()

    def _given(self, task: ProcessTask) -> _Worker:
        worker = self._worker or _Worker(self._count, self._nice)
        with self._lock:
            self._worker, self._in_work = worker, task
            worker.send(task, is_order=False)
            for word in self._orders.get(task, ()):
                worker.send(word)
        return worker

    def _result(
        self,
        worker: _Worker,
        hear: Callable[[Any], None],
        unwanted: Callable[[], bool],
        *,
        listens: bool,
    ) -> Any:
        word, stops = None, False
        try:
            while not isinstance(word, _Done | Exception):
                if worker.pipe.poll(_LOOK_SECONDS):
                    word = worker.word()
                    self._heard = True
                    if not isinstance(word, _Done | Exception):
                        hear(word)
                if not stops and unwanted():
                    stops = True
                    with self._lock:
                        if listens and not self._closed:
                            worker.send(Stop())
                        else:
                            worker.process.terminate()
        except BaseException:
            self._drop()  # what it may still tell is not for the next task
            raise
        finally:
            self._in_work = None
        if isinstance(word, Exception):
            raise word
        if stops:
            raise Cancelled
        return word.result

    def _drop(self) -> None:
        with self._lock:
            worker, self._worker = self._worker, None
        if worker is not None:
            worker.end()


def usable_cores() -> int:
    """Cores that this program may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def _without_main() -> Iterator[None]:
    """Keep a process from importing the script that starts it, which would run it once more.

    What the process does is never defined there, so scripts need no ``if __name__ == "__main__"``.
    """
    main, sys.modules["__main__"] = sys.modules["__main__"], ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main


@contextmanager
def _environment(values: Mapping[str, str]) -> Iterator[None]:
    """Set variables that a process inherits: libraries look at them when they are loaded."""
    before = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


@contextmanager
def _out_of_reach_of_interrupts() -> Iterator[None]:
    """Start processes that Ctrl-C never reaches, not even while they load what they need.

    A terminal sends it to every process; only the one that asks for work decides.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    from multiprocessing import resource_tracker

    resource_tracker.ensure_running()  # starting it later would let interrupts through again
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _serve(pipe: Connection, threads: int, nice: int) -> None:
    """Do tasks until nobody asks any more, or whoever asked is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    if nice and hasattr(os, "nice"):
        os.nice(nice)
    cv2.setNumThreads(threads)
    asker = Asker(pipe)
    with one_blas_thread(), suppress(EOFError, BrokenPipeError, ConnectionResetError):
        while True:
            task, result = asker.next_task(), None
            try:
                with suppress(Cancelled):
                    result = task(asker)
                asker.tell(_Done(result))
            except (BrokenPipeError, ConnectionResetError):
                raise
            except Exception as error:  # noqa: BLE001 - raised where the task was asked for
                asker.tell(portable(error))


def _end_with_parent() -> None:
    """End this process when the one that started it has ended, killed, too, whatever it is at.

    A pipe tells, that closes with the parent; a task that listens to nobody would go on for long.
    """
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
