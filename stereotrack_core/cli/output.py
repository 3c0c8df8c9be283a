"""What the commands write: results to standard output, everything else to standard error."""

import contextlib
import json
import logging
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from io import StringIO
from types import FrameType
from typing import IO, Any, TextIO, cast

from stereotrack_core.errors import Cancelled, visible
from stereotrack_core.plain_data import plain
from stereotrack_core.tables import Table
from stereotrack_core.work import Work

OK, FAILED, WRONG_INPUT = 0, 1, 2
"""Exit status: done; something else went wrong, or it was stopped; the user's input is wrong."""

_WIDTH_WITHOUT_TERMINAL = 160


def put(text: str) -> None:
    """Write a result to standard output; OSError where a drive is full or a terminal closed."""
    try:
        _write(sys.stdout, text)
    except OSError as error:
        if error.filename is None:
            error.filename = "standard output"
        raise


class _StandardError(logging.Handler):
    """Writes to what standard error is at the time; where that cannot be, work goes on."""

    def emit(self, record: logging.LogRecord) -> None:
        """Write one message."""
        with contextlib.suppress(OSError):
            _write(sys.stderr, record.getMessage())


_MESSAGES = logging.getLogger("stereotrack")
_MESSAGES.addHandler(_StandardError())
_MESSAGES.setLevel(logging.INFO)
_MESSAGES.propagate = False


def say(text: str) -> None:
    """Write a message for the person to standard error, unless ``--quiet`` asks for silence."""
    _MESSAGES.info("%s", text)


def complain(text: str) -> None:
    """Write to standard error why a command ends without its result."""
    _MESSAGES.error("%s", text)


@contextmanager
def speaking(*, quiet: bool) -> Iterator[None]:
    """Say nothing but errors while the block runs, if that is asked for."""
    before = _MESSAGES.level
    _MESSAGES.setLevel(logging.ERROR if quiet else before)
    try:
        yield
    finally:
        _MESSAGES.setLevel(before)


def _write(stream: TextIO, text: str) -> None:
    """Write a line; control characters are spelled out, unknown letters become question marks."""
    encoding = getattr(stream, "encoding", None) or "utf-8"
    stream.write(visible(text).encode(encoding, "replace").decode(encoding) + "\n")
    stream.flush()


def put_json(value: Any) -> None:
    """Write a result as JSON; what is not a number becomes null."""
    put(json.dumps(plain(value), indent=2, ensure_ascii=False, allow_nan=False))


def put_table(table: Table) -> None:
    """Write a table to standard output, never cut off where there is no terminal."""
    from rich import box
    from rich.console import Console
    from rich.table import Table as RichTable
    from rich.text import Text

    drawn = RichTable(box=box.SIMPLE_HEAD)
    for heading in table.columns:
        right = heading.startswith(">")
        text = Text(visible(heading.removeprefix(">")))
        drawn.add_column(text, justify="right" if right else "left", overflow="fold")
    for row in table.rows:
        drawn.add_row(*(Text(visible(cell)) for cell in row))
    terminal = sys.stdout.isatty()
    buffer = StringIO()
    width = None if terminal else _WIDTH_WITHOUT_TERMINAL
    console = Console(file=sys.stdout if terminal else buffer, width=width, highlight=False)
    console.print(Text(visible(table.title), style="bold"), drawn, sep="\n")
    if not terminal:
        put("\n".join(line.rstrip() for line in buffer.getvalue().rstrip().split("\n")) + "\n")


def put_facts(facts: Mapping[str, Any], title: str, *, as_json: bool, **more: Any) -> None:
    """Write a result as JSON, with `more`, or as a table of two columns."""
    rows = [
        (name.replace("_", " "), ", ".join(value) if isinstance(value, list) else str(value))
        for name, value in facts.items()
    ]
    put_result({**facts, **more}, Table(title, ("what", ">value"), rows), as_json=as_json)


def put_result(facts: Any, *told: Table | str | None, as_json: bool) -> None:
    """Write a result to standard output, as JSON or as tables and sentences."""
    if as_json:
        put_json(facts)
        return
    for one in told:
        if isinstance(one, str):
            put(f"{one}\n")
        elif one is not None:
            put_table(one)


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


@contextmanager
def progress(what: str, total: int | None) -> Iterator[Callable[..., None]]:
    """Give a function that draws, on a terminal alone, how many steps are done.

    It may also be told what is being done now, where that is not what was begun.
    """
    if not (_MESSAGES.isEnabledFor(logging.INFO) and sys.stderr.isatty()):
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
def stoppable(outcome: str = "", *, at_once: bool = False) -> Iterator[Callable[[], bool]]:
    """Give a function that says whether Ctrl-C was pressed; a second time stops at once.

    `outcome` is what a person is told about work that is stopped. `at_once`: nobody asks.

    A request to end and a terminal that is closed count as Ctrl-C; the latter not where somebody
    has said before that the program shall outlive it (``nohup``).

    Outside the main thread, where signals cannot be caught, it always says no.
    """
    asked = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield asked.is_set
        return

    def stop(number: int, frame: FrameType | None) -> None:
        if at_once:
            raise Cancelled
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
def watched(what: str, outcome: str) -> Iterator[Work]:
    """Show how far long work is, which Ctrl-C stops."""
    with progress(what, 100) as show, stoppable(outcome) as stopped:
        yield Work(lambda share, _: show(round(100 * share)), stopped)
