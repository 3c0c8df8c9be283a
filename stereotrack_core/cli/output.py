"""What the commands write: results to standard output, everything else to standard error."""

from __future__ import annotations

import contextlib
import json
import logging
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from io import StringIO
from typing import Any, TextIO

from stereotrack_core.errors import visible
from stereotrack_core.plain_data import plain
from stereotrack_core.tables import Table

OK, FAILED, WRONG_INPUT = 0, 1, 2
"""Exit status: done; something else went wrong, or it was stopped; the user's input is wrong."""

_WIDTH_WITHOUT_TERMINAL = 160


def put(text: str) -> None:
    """Write a result to standard output.

    Raises OSError where it goes to a file on a drive that is full, or to a terminal that has been
    closed.
    """
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


def is_quiet() -> bool:
    """Whether messages and progress are not wanted."""
    return not _MESSAGES.isEnabledFor(logging.INFO)


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
        drawn.add_column(
            Text(visible(heading.removeprefix(">"))),
            justify="right" if right else "left",
            overflow="fold",
        )
    for row in table.rows:
        drawn.add_row(*(Text(visible(cell)) for cell in row))
    terminal = sys.stdout.isatty()
    buffer = StringIO()
    console = Console(
        file=sys.stdout if terminal else buffer,
        width=None if terminal else _WIDTH_WITHOUT_TERMINAL,
        highlight=False,
    )
    console.print(Text(visible(table.title), style="bold"), drawn, sep="\n")
    if not terminal:
        put("\n".join(line.rstrip() for line in buffer.getvalue().rstrip().split("\n")) + "\n")


def put_result(facts: Any, *tables: Table, as_json: bool) -> None:
    """Write a result to standard output, as JSON or as tables."""
    if as_json:
        put_json(facts)
    for table in () if as_json else tables:
        put_table(table)
