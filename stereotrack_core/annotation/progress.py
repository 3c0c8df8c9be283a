"""How far the annotation is: what is clicked, what is missing, which frames are done."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

StateArray: TypeAlias = NDArray[np.uint8]


class LaneState(IntEnum):
    """What a landmark's lane shows at a frame; the larger number is shown where two meet."""

    MISSING = 0
    PARTLY = 1
    CLICKED = 2
    FLAGGED = 3


class Seen(NamedTuple):
    """What all cameras together say about a landmark at a frame.

    Attributes
    ----------
    positions : int
        Cameras in which it has a position.
    doubted : bool
        Whether the author of a click doubts it.
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
    keyframes : int
        Frames that shall be annotated.
    done : int
        Those of them that are.
    flagged : int
        Keyframes that somebody wants to look at again.
    clicks : int
        All clicks, on whichever frame.
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
    """Count what is done of the frames that shall be annotated.

    `flagged` frames are flagged, or have a click that its author doubts.
    """
    return Progress(
        keyframes=len(keyframes),
        done=sum(keyframes.values()),
        flagged=len(keyframes.keys() & set(flagged)),
        clicks=clicks,
    )


def lane_states(
    found: Iterable[Seen],
    landmarks: Sequence[str],
    frames: int,
    *,
    enough: int = 2,
    flags: Iterable[tuple[int, str]] = (),
) -> StateArray:
    """What the landmarks' lanes show (n, F), as values of :class:`LaneState`.

    A landmark counts as clicked from `enough` cameras on. A flag has a frame and a landmark; an
    empty landmark flags the frame in every lane. Other landmarks and frames are passed over.
    """
    place = {name: i for i, name in enumerate(landmarks)}
    states = np.full((len(landmarks), frames), LaneState.MISSING, dtype=np.uint8)
    for one in found:
        lane = place.get(one.landmark)
        if lane is None or not 0 <= one.frame < frames:
            continue
        if one.doubted:
            states[lane, one.frame] = LaneState.FLAGGED
        elif one.positions:
            clicked = one.positions >= enough
            states[lane, one.frame] = LaneState.CLICKED if clicked else LaneState.PARTLY
    for frame, landmark in flags:
        if 0 <= frame < frames and (not landmark or landmark in place):
            states[place[landmark] if landmark else slice(None), frame] = LaneState.FLAGGED
    return states
