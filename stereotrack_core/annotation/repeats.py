"""Which frames are annotated a second time, blindly, to measure how good clicks are."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Sequence


def next_repeat(
    done: Sequence[int],
    repeated: Collection[int],
    share: float,
    *,
    apart: int = 20,
    seed: int = 0,
) -> int | None:
    """The frame to be annotated again now; None while none is due.

    Parameters
    ----------
    done : sequence of int
        Frames in the order in which they were annotated first.
    repeated : collection of int
        Those that have been annotated again.
    share : float
        Part of the frames that is annotated again, 0 to 1.
    apart : int
        Frames that were annotated since, so that nobody remembers the places.
    seed : int
        The choice is at random, but the same for the same seed and frame, so that it does not
        change when the project is opened again.

    Raises
    ------
    ValueError
        Where the share is not between 0 and 1.
    """
    if not 0.0 <= share <= 1.0:
        raise ValueError(f"a share of {share} is not between 0 and 1")
    known = set(repeated)
    if len(known & set(done)) >= int(share * len(done)):
        return None
    waiting = [frame for frame in done[: max(0, len(done) - apart)] if frame not in known]
    return min(waiting, key=lambda frame: _lot(seed, frame), default=None)


def _lot(seed: int, frame: int) -> bytes:
    return hashlib.blake2b(f"{seed} {frame}".encode(), digest_size=8).digest()
