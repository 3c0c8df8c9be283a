"""Long work as whoever waits for it sees it: how far it is, and whether it is still wanted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from stereotrack_core.errors import Cancelled


@dataclass(frozen=True)
class Work:
    """Handed to a long function; by default nobody is told, and it is never stopped."""

    tell: Callable[[float, str], None] = lambda _share, _words: None
    """Takes the share that is done, 0 to 1, and what is being done in words."""
    stopped: Callable[[], bool] = lambda: False

    def check(self) -> None:
        """Raise Cancelled if it is no longer wanted."""
        if self.stopped():
            raise Cancelled

    def step(self, share: float, words: str) -> None:
        """Tell how far it is, unless it is no longer wanted. Raises Cancelled."""
        self.check()
        self.tell(share, words)

    def part(self, first: float, end: float) -> Work:
        """A part of it, which goes from one share of the whole to another."""
        return Work(
            lambda share, words: self.tell(first + share * (end - first), words), self.stopped
        )


NO_WORK = Work()
