"""How far the annotation is: what is clicked, what is missing, which frames are done."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from stereotrack_core.annotation.click import UNCERTAIN, Click

StateArray: TypeAlias = NDArray[np.uint8]


class LaneState(IntEnum):
    """What a landmark's lane shows at a frame; the larger number is shown where two meet."""

    MISSING = 0
    FILLED = 1
    PARTLY = 2
    CLICKED = 3
    FLAGGED = 4


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
            return f"{text}, no keyframes chosen"
        flagged = f", {self.flagged} flagged" if self.flagged else ""
        return f"{self.done} of {self.keyframes} keyframes{flagged}"


def progress(
    keyframes: Mapping[int, bool], flagged: Collection[int], clicks: Iterable[Click]
) -> Progress:
    """Count what is done.

    Parameters
    ----------
    keyframes : mapping from frame to bool
        Whether each frame that shall be annotated is done.
    flagged : collection of int
        Frames with a flag.
    clicks : iterable of Click
        A click that its author doubts flags its frame.
    """
    there = [click for click in clicks if not click.deleted]
    doubted = {click.frame for click in there if click.flag == UNCERTAIN}
    return Progress(
        keyframes=len(keyframes),
        done=sum(keyframes.values()),
        flagged=len(keyframes.keys() & (doubted | set(flagged))),
        clicks=len(there),
    )


def missing_at(
    clicks: Iterable[Click], cameras: Sequence[str], landmarks: Sequence[str]
) -> tuple[tuple[str, str], ...]:
    """Pairs (camera, landmark) that a frame has no click of, in the order of clicking.

    Landmark by landmark over all cameras; a click that says "outside" is one, a deleted one is not.
    """
    there = {(click.camera, click.landmark) for click in clicks if not click.deleted}
    wanted = [(camera, landmark) for landmark in landmarks for camera in cameras]
    return tuple(one for one in wanted if one not in there)


def next_keyframe(
    keyframes: Mapping[int, bool], frame: int, *, backwards: bool = False
) -> int | None:
    """The nearest keyframe after (before) `frame` that is not done; None where there is none."""
    waiting = [one for one, done in keyframes.items() if not done]
    if backwards:
        return max((one for one in waiting if one < frame), default=None)
    return min((one for one in waiting if one > frame), default=None)


def lane_states(
    clicks: Iterable[Click],
    landmarks: Sequence[str],
    frames: int,
    *,
    enough: int = 2,
    flags: Iterable[tuple[int, str]] = (),
    filled: Collection[int] = (),
) -> StateArray:
    """What the landmarks' lanes show, by frame.

    Parameters
    ----------
    clicks : iterable of Click
        Of landmarks or frames that are not asked for: passed over.
    landmarks : sequence of str
        n lanes.
    frames : int
        Number of frames F.
    enough : int
        Number of cameras with a position from which on a landmark counts as clicked.
    flags : iterable of (int, str)
        Frame and landmark; an empty landmark flags the frame in every lane.
    filled : collection of int
        Frames whose pose was filled in between others.

    Returns
    -------
    (n, F) uint8
        Values of :class:`LaneState`.
    """
    place = {name: i for i, name in enumerate(landmarks)}
    counts = np.zeros((len(landmarks), frames), dtype=np.int64)
    doubted = np.zeros((len(landmarks), frames), dtype=bool)
    for click in clicks:
        lane = place.get(click.landmark)
        if lane is None or click.deleted or click.frame >= frames:
            continue
        counts[lane, click.frame] += click.position is not None
        doubted[lane, click.frame] |= click.flag == UNCERTAIN
    for frame, landmark in flags:
        if 0 <= frame < frames and (not landmark or landmark in place):
            doubted[place[landmark] if landmark else slice(None), frame] = True
    states = np.full(counts.shape, LaneState.MISSING, dtype=np.uint8)
    states[:, [frame for frame in filled if 0 <= frame < frames]] = LaneState.FILLED
    states[counts > 0] = LaneState.PARTLY
    states[counts >= enough] = LaneState.CLICKED
    states[doubted] = LaneState.FLAGGED
    return states
