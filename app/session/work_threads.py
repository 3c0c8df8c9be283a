"""Threads of the window, which work beside its own."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import suppress
from queue import Empty, SimpleQueue

_IDLE, _STAYS_S = "idle", 2.0


class WorkThread(threading.Thread):
    """A thread of the window's; the program does not wait for it for ever.

    It stays for the next work for a while: a new thread has to be waited for until it runs.
    """

    def __init__(self, idle: list[WorkThread]) -> None:
        super().__init__(daemon=True)
        self._idle = idle
        self._todo = SimpleQueue[tuple[str, Callable[[], object]]]()

    def do(self, title: str, work: Callable[[], object]) -> None:
        """Do this next."""
        self._todo.put((title, work))
        if not self.is_alive():
            self.start()

    def run(self) -> None:
        while todo := self._next():
            self.name, work = todo
            work()
            del todo, work  # nothing is kept of it
            self._idle.append(self)
            self.name = _IDLE

    def _next(self) -> tuple[str, Callable[[], object]] | None:
        with suppress(Empty):
            return self._todo.get(timeout=_STAYS_S)
        with suppress(ValueError):
            self._idle.remove(self)
            return None
        return self._todo.get()  # whoever took it from the list has something to do


def wait_for_threads(seconds: float) -> None:
    """Let the window's threads end that were told to; called when nobody looks any more."""
    end = time.monotonic() + seconds
    while _busy() and time.monotonic() < end:
        time.sleep(0.02)


def _busy() -> bool:
    threads = (one for one in threading.enumerate() if isinstance(one, WorkThread))
    return any(thread.name != _IDLE for thread in threads)
