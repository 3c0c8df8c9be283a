"""Progress on a terminal, and stopping with Ctrl-C, or when the terminal is closed."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import IO, Any, Protocol, TextIO, cast

from stereotrack_core.cli.output import is_quiet
from stereotrack_core.errors import Cancelled


class _Terminal:
    """Standard error, written to for as long as there is somebody to see it."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """Write, unless the terminal has been closed."""
        with contextlib.suppress(OSError):
            self._stream.write(text)
        return len(text)

    def flush(self) -> None:
        """Show what was written, unless the terminal has been closed."""
        with contextlib.suppress(OSError):
            self._stream.flush()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


class Show(Protocol):
    """Draws how many steps are done."""

    def __call__(self, done: int, now: str = "") -> None:
        """`now` says what is being done, where it is not what was begun."""


@contextmanager
def progress(what: str, total: int | None) -> Iterator[Show]:
    """Give a function that is told how many steps are done; draws only on a terminal."""
    if is_quiet() or not sys.stderr.isatty():
        yield lambda *_: None
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeRemainingColumn,
    )

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    console = Console(file=cast(IO[str], _Terminal(sys.stderr)))
    with Progress(*columns, TimeRemainingColumn(), console=console, transient=True) as bar:
        task = bar.add_task(what, total=total)
        yield lambda done, now="": bar.update(task, completed=done, description=now or what)


@contextmanager
def stoppable(outcome: str = "") -> Iterator[Callable[[], bool]]:
    """Give a function that says whether Ctrl-C was pressed; a second time stops at once.

    `outcome` is what a person is told about work that is stopped.

    A request to end and a terminal that is closed count as Ctrl-C; the latter not where somebody
    has said before that the program shall outlive it (``nohup``).

    Outside the main thread, where signals cannot be caught, it always says no.
    """
    asked = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield asked.is_set
        return

    def stop(number: int, frame: FrameType | None) -> None:
        if asked.is_set():
            signal.default_int_handler(number, frame)
        asked.set()
        if number == signal.SIGINT and sys.stderr.isatty():
            # not through the stream, which may be in the middle of a line of its own
            with contextlib.suppress(OSError):
                os.write(sys.stderr.fileno(), b"\nStopping; Ctrl-C once more stops at once.\n")

    wanted = [signal.SIGINT, signal.SIGTERM]
    if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:
        wanted.append(signal.SIGHUP)
    before = {number: signal.signal(number, stop) for number in wanted}
    try:
        yield asked.is_set
    except Cancelled:
        raise Cancelled(outcome) from None
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def watched(
    what: str, outcome: str
) -> Iterator[tuple[Callable[[float, str], None], Callable[[], bool]]]:
    """Give what is told the share that is done, with words, and what says whether to stop."""
    with progress(what, 100) as show, stoppable(outcome) as stopped:
        yield lambda share, _: show(round(100 * share)), stopped
