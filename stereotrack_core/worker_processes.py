"""Processes of this machine that do one task after the other, each on its share of the cores.

Unlike :class:`concurrent.futures.ProcessPoolExecutor` they can be ended at any moment, tell how
far they are, and one of them that is killed takes no other with it. They never outlive the one
that has started them.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from typing import Any, Protocol

import cv2

from stereotrack_core.blas_threads import one_blas_thread
from stereotrack_core.errors import Cancelled, portable

_TELL_SECONDS = 0.2
_LAST_WORD_SECONDS = 5.0
_LOOK_SECONDS = 0.2
_CONTEXT = multiprocessing.get_context("spawn")
_STARTING = threading.Lock()
"""Held while a process is started, which inherits variables that are set for it."""


@dataclass(frozen=True)
class Stop:
    """The order to end a task that is no longer wanted."""


class Asker:
    """Whoever wants a task done, as the process at work knows it.

    Attributes
    ----------
    kept : dict
        What tasks leave in the process for those after them.
    """

    def __init__(self, pipe: Connection) -> None:
        self.kept: dict[str, Any] = {}
        self._pipe = pipe
        self._listening = threading.Lock()
        self._stopped = False
        self._untold = 0
        self._told = 0.0

    def on_frames(self, count: int) -> None:
        """So many frames more are done; told some times a second."""
        self._untold += count
        if time.monotonic() - self._told > _TELL_SECONDS:
            self._tell_frames()

    def tell(self, word: Any) -> None:
        """Tell something that is neither a number nor None; numbers that wait go first."""
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
        """Whether the task in work is no longer wanted; for tasks that hear no other orders.

        May be asked by several threads.
        """
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


class Lost(Exception):
    """A process has ended by itself, with an exit code, in the middle of a task."""

    def __init__(self, code: int | None) -> None:
        super().__init__(f"the process at work ended unexpectedly (exit code {code})")


class WorkerProcess:
    """A process that waits for tasks, one of `count` that share the machine's cores.

    `do` is what it does with a task: a function of a module, called with the task and an
    :class:`Asker`. What it raises is told as a word.
    """

    def __init__(self, do: Callable[[Any, Asker], None], count: int, *, nice: int = 0) -> None:
        self.pipe, theirs = _CONTEXT.Pipe()
        threads = max(1, usable_cores() // count)
        arguments = (theirs, do, threads, nice)
        self._process = _CONTEXT.Process(target=_serve, args=arguments, daemon=True)
        libraries = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
        limits = {**dict.fromkeys(libraries, "1"), "NUMBA_NUM_THREADS": str(threads)}
        with _STARTING, _environment(limits), _out_of_reach_of_interrupts():
            self._process.start()
        theirs.close()
        self.busy = False

    @property
    def pid(self) -> int | None:
        """Number of the process."""
        return self._process.pid

    def give(self, task: Any) -> None:
        """Let it do a task; one that has died is found out by listening to it."""
        self.busy = True
        self._send(False, task)

    def order(self, word: Any) -> None:
        """Say something about the task in work; see :meth:`Asker.orders`."""
        self._send(True, word)

    def terminate(self) -> None:
        """Have it ended, without waiting for that; see :func:`end`."""
        self._process.terminate()

    def _send(self, is_order: bool, word: Any) -> None:
        with suppress(BrokenPipeError, ConnectionResetError):
            self.pipe.send((is_order, word))

    def words(self) -> Iterator[Any]:
        """What it has told since it was last listened to.

        Numbers are frames done, exceptions what a task failed of, all else is what the task tells.
        After the task's last word it is no longer busy. Raises :class:`Lost` where it has ended; it
        must be ended nevertheless.
        """
        try:
            while self.pipe.poll():
                word = self.pipe.recv()
                if word is None:
                    self.busy = False
                else:
                    yield word
        except (EOFError, OSError):  # the latter in the middle of a word
            self._process.join(_LAST_WORD_SECONDS)
            raise Lost(self._process.exitcode) from None


def with_words(workers: Sequence[WorkerProcess], seconds: float | None) -> list[WorkerProcess]:
    """Those that have something to tell, or have died; waits for the first so long at most."""
    ready = wait([worker.pipe for worker in workers], seconds)
    return [worker for worker in workers if worker.pipe in ready]


def end(workers: Sequence[WorkerProcess]) -> None:
    """End processes at once; what they are at is lost."""
    for worker in workers:
        worker.terminate()
    for worker in workers:
        worker._process.join(_LAST_WORD_SECONDS)
        if worker._process.is_alive():
            worker._process.kill()
            worker._process.join()
        worker.pipe.close()


def usable_cores() -> int:
    """Cores that this program may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


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


def _serve(pipe: Connection, do: Callable[[Any, Asker], None], threads: int, nice: int) -> None:
    """Do tasks until nobody asks any more, or whoever asked is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    if nice and hasattr(os, "nice"):
        os.nice(nice)
    cv2.setNumThreads(threads)
    asker = Asker(pipe)
    with one_blas_thread(), suppress(EOFError, BrokenPipeError, ConnectionResetError, Cancelled):
        while True:
            task = asker.next_task()
            try:
                do(task, asker)
            except (BrokenPipeError, ConnectionResetError, Cancelled):
                raise
            except Exception as error:  # noqa: BLE001 - told to whoever asked
                asker.tell(portable(error))
            pipe.send(None)


def _end_with_parent() -> None:
    """End this process when the one that started it has ended, killed, too, whatever it is at.

    A pipe tells, that closes with the parent; a task that listens to nobody would go on for long.
    """
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


class Desk(Protocol):
    """Whoever has tasks for a pool, and hears what becomes of them."""

    def next(self) -> Any:
        """The next task; None where nothing waits at this moment."""

    def heard(self, task: Any, word: Any) -> None:
        """A task tells something: frames done, what it failed of, or anything else."""

    def lost(self, task: Any, why: Lost) -> None:
        """The process that was at a task has ended by itself."""

    def ended(self, task: Any) -> None:
        """A task has come to its end."""

    def stopped(self) -> bool:
        """Whether to stop."""


class Pool:
    """`count` processes that are started when there is work, and live until they are ended.

    For `do` see :class:`WorkerProcess`.
    """

    def __init__(self, do: Callable[[Any, Asker], None], count: int) -> None:
        self._do = do
        self._at: dict[WorkerProcess, Any] = {}
        self.count = count
        self.workers: list[WorkerProcess] = []

    def work(self, desk: Desk) -> None:
        """Do tasks until there are none.

        Raises :class:`Cancelled` where the desk wants to stop; all processes are ended then.
        """
        while True:
            self._hand_out(desk)
            if not self._at:
                return
            for worker in with_words(list(self._at), _LOOK_SECONDS):
                self._listen(worker, desk)
            if desk.stopped():
                self.close()
                raise Cancelled

    def close(self) -> None:
        """End all processes at once; what they are at is lost."""
        end(self.workers)
        self.workers.clear()
        self._at.clear()

    def _hand_out(self, desk: Desk) -> None:
        while len(self._at) < self.count:
            task = desk.next()
            if task is None:
                return
            worker = next((one for one in self.workers if one not in self._at), None)
            if worker is None:
                worker = WorkerProcess(self._do, self.count)
                self.workers.append(worker)
            self._at[worker] = task
            worker.give(task)

    def _listen(self, worker: WorkerProcess, desk: Desk) -> None:
        task = self._at[worker]
        try:
            for word in worker.words():
                desk.heard(task, word)
        except Lost as lost:
            end([worker])
            self.workers.remove(worker)
            del self._at[worker]
            desk.lost(task, lost)
            return
        if not worker.busy:
            del self._at[worker]
            desk.ended(task)
