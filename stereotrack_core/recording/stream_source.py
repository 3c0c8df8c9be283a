"""What a video and a set of numbered images have in common."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol, TypeAlias

from numpy.typing import NDArray

Keep: TypeAlias = Callable[[int, NDArray[Any]], None]
"""Is given the number and the pixels of every picture that decoding yields on the way."""


class DamagedFrame(Exception):
    """A single frame cannot be decoded; the text says why, as a clause."""


class StreamSource(Protocol):
    """Pictures by their number in the stream's own counting; used by one thread at a time."""

    def count(self) -> int:
        """Number of frames; may wait until the stream has been read to its end."""

    def count_so_far(self) -> tuple[int, bool]:
        """Number of frames known or estimated now, and whether it is final; never waits."""

    def missing(self) -> tuple[int, ...]:
        """Numbers of files that are absent between the first and the last."""

    def read(self, k: int, keep: Keep) -> NDArray[Any]:
        """Picture of frame k; DamagedFrame where it cannot be decoded."""

    def close(self) -> None:
        """Release files and threads."""
