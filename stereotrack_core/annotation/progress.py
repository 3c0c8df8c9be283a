"""How far the annotation is: what is clicked, what is missing, which frames are done."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import NamedTuple


class Seen(NamedTuple):
    """What all cameras together say about a landmark at a frame.

    `positions`: cameras in which it has a position. `doubted`: whether the author of a click doubts
    it.
    """

    frame: int
    landmark: str
    positions: int
    doubted: bool


@dataclass(frozen=True)
class Progress:
    """Keyframes counted.

    Attributes
    ----------
    keyframes : frames that shall be annotated
    done : those of them that are
    flagged : keyframes that somebody wants to look at again
    clicks : all clicks, on whichever frame
    """

    keyframes: int
    done: int
    flagged: int
    clicks: int

    @property
    def share(self) -> float:
        """Part of the keyframes that is done, 0 to 1; 0 without keyframes."""
        return self.done / self.keyframes if self.keyframes else 0.0

    def words(self) -> str:
        """``214 of 300 keyframes, 3 flagged``."""
        if not self.keyframes:
            text = f"{self.clicks} click{'' if self.clicks == 1 else 's'}"
            return f"{text}, no keyframes set"
        flagged = f", {self.flagged} flagged" if self.flagged else ""
        return f"{self.done} of {self.keyframes} keyframes done{flagged}"


def progress(keyframes: Mapping[int, bool], flagged: Collection[int], clicks: int) -> Progress:
    """Count what is done.

    `keyframes` mapping from frame to bool, whether each frame that shall be annotated is done.
    `flagged`: frames that are flagged, or have a click that its author doubts.
    """
    return Progress(
        keyframes=len(keyframes),
        done=sum(keyframes.values()),
        flagged=len(keyframes.keys() & set(flagged)),
        clicks=clicks,
    )
