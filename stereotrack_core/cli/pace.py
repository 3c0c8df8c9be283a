"""How far long work is and how long it will still take: a bar, or a line now and then."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from stereotrack_core.cli.output import say
from stereotrack_core.cli.progress import progress

_QUIET = 300.0
"""Seconds between two lines where no bar is drawn."""


class Pace:
    """Follows work of which so much is to be done.

    Parameters
    ----------
    what : str
        What is being done.
    total : int
        Steps.
    show : callable
        Draws how many are done.
    """

    def __init__(self, what: str, total: int, show: Callable[[int], None]) -> None:
        self._what = what
        self._total = total
        self._show = show
        self._begun = self._said = time.monotonic()
        self._before = 0
        self.done = 0

    def advance(self, steps: int, *_: int) -> None:
        """So many steps of the present piece of work are done."""
        self.done = self._before + steps
        self._show(self.done)
        now = time.monotonic()
        if not sys.stderr.isatty() and now - self._said > _QUIET:
            self._said = now
            say(f"{self._what}: {self.done} of {self._total} frames; {self.words()}.")

    def next(self, steps: int) -> None:
        """A piece of work of so many steps is finished."""
        self._before += steps
        self.advance(0)

    def words(self) -> str:
        """``12 min so far, about 1 h 5 min left``."""
        elapsed = time.monotonic() - self._begun
        so_far = f"{duration(elapsed)} so far"
        if not self.done:
            return so_far
        left = elapsed * (self._total - self.done) / self.done
        return f"{so_far}, about {duration(left)} left"


@contextmanager
def pace(what: str, total: int) -> Iterator[Pace]:
    """Follow work while the block runs."""
    with progress(what, total) as show:
        yield Pace(what, total, show)


def duration(seconds: float) -> str:
    """``45 s``, ``12 min`` or ``1 h 5 min``."""
    if seconds < 90:
        return f"{round(seconds)} s"
    minutes = round(seconds / 60)
    return f"{minutes // 60} h {minutes % 60} min" if minutes >= 60 else f"{minutes} min"
