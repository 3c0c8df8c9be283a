"""A process that does what threads ask it for, so that a window always paints."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, TypeAlias
from weakref import WeakKeyDictionary

from stereotrack_core.errors import Cancelled
from stereotrack_core.worker_processes import Asker, Lost, Stop, WorkerProcess, end, with_words

ProcessTask: TypeAlias = Callable[[Asker], Any]
"""Picklable; called in the process, it returns its result, tells what it has to and hears orders
from the :class:`Asker`."""

_LOOK_SECONDS = 0.1
_NICE = 15
"""Who paints goes first; where nothing is to be painted, nothing is lost."""


def ignore(_: Any) -> None:
    """Take no notice."""


def never() -> bool:
    """What asks nobody whether to stop."""
    return False


@dataclass(frozen=True)
class _Done:
    """The last word of a task that has not failed."""

    result: Any


def _do(task: ProcessTask, asker: Asker) -> None:
    result = None
    with suppress(Cancelled):
        result = task(asker)
    asker.tell(_Done(result))


class TaskProcess:
    """Started with its first task, it does one after the other; threads wait for theirs."""

    def __init__(self) -> None:
        self._lock, self._turn = threading.Lock(), threading.Lock()
        self._worker: WorkerProcess | None = None
        self._in_work: ProcessTask | None = None
        self._orders: WeakKeyDictionary[ProcessTask, list[Any]] = WeakKeyDictionary()
        self._heard = self._closed = False

    def __call__(
        self,
        task: ProcessTask,
        hear: Callable[[Any], None] = ignore,
        cancelled: Callable[[], bool] = never,
        *,
        listens: bool = True,
    ) -> Any:
        """Have a task done, when those before are; what it returns.

        A process that has ended before it has told anything is started anew, once.

        Parameters
        ----------
        task : ProcessTask
        hear : callable
            Called with each word that the task tells.
        cancelled : callable
            Whether the task is no longer wanted; asked some times a second.
        listens : bool
            Whether the task looks at its orders. Otherwise the process is ended to cancel it.

        Raises
        ------
        Exception
            What the task raised.
        Cancelled
            Where the task is no longer wanted, or the process is closed.
        Lost
            Where the process has ended by itself.
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
        return None if self._worker is None else self._worker.pid

    def order(self, task: ProcessTask, word: Any) -> None:
        """Say something about a task that is in work, or waits for its turn."""
        with self._lock:
            self._orders.setdefault(task, []).append(word)
            if task is self._in_work and self._worker is not None:
                self._worker.order(word)

    def end(self) -> None:
        """End the process at once, with the task in work; the next task starts another one."""
        with self._lock:
            if self._worker is not None:
                self._worker.terminate()
        if self._turn.acquire(blocking=False):  # no thread is there that would find it out
            self._drop()
            self._turn.release()

    def close(self) -> None:
        """End the process for good; whoever waits for it gets :class:`Cancelled`."""
        self._closed = True
        self.end()

    def _given(self, task: ProcessTask) -> WorkerProcess:
        worker = self._worker or WorkerProcess(_do, 1, nice=_NICE)
        with self._lock:
            self._worker, self._in_work = worker, task
            worker.give(task)
            for word in self._orders.get(task, ()):
                worker.order(word)
        return worker

    def _result(
        self,
        worker: WorkerProcess,
        hear: Callable[[Any], None],
        unwanted: Callable[[], bool],
        *,
        listens: bool,
    ) -> Any:
        last: Any = None
        stops = False
        try:
            while worker.busy:
                with_words([worker], _LOOK_SECONDS)
                for word in worker.words():
                    self._heard = True
                    if isinstance(word, _Done | Exception):
                        last = word
                    else:
                        hear(word)
                if not stops and unwanted():
                    stops = True
                    with self._lock:
                        if listens and not self._closed:
                            worker.order(Stop())
                        else:
                            worker.terminate()
        except BaseException:
            self._drop()  # what it may still tell is not for the next task
            raise
        finally:
            self._in_work = None
        if isinstance(last, Exception):
            raise last
        if stops:
            raise Cancelled
        return last.result

    def _drop(self) -> None:
        """End the process, in one's turn."""
        with self._lock:
            worker, self._worker = self._worker, None
        if worker is not None:
            end([worker])
