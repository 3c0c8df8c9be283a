"""What lanes of the timeline hold, their summary for any width, and where frames stand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import IntEnum
from functools import cached_property
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from stereotrack_core.arrays import FloatArray, IntArray

LaneKind: TypeAlias = Literal["heat", "marks", "bars"]
MarkArray: TypeAlias = NDArray[np.uint8]


class Mark(IntEnum):
    """What a lane of marks says about a frame."""

    NONE = 0
    INTERPOLATED = 1
    MISSING = 2
    CLICKED = 3
    FLAGGED = 4
    PARTLY = 5
    GAP = 6
    PROPOSED = 7


MARK_WORDS = {
    Mark.NONE: "nothing",
    Mark.INTERPOLATED: "interpolated",
    Mark.MISSING: "missing",
    Mark.CLICKED: "clicked",
    Mark.FLAGGED: "flagged",
    Mark.PARTLY: "clicked, but in too few views",
    Mark.GAP: "gap, not interpolated",
    Mark.PROPOSED: "proposed, not accepted",
}


@dataclass(frozen=True)
class Span:
    """A stretch of frames, both ends included."""

    first: int
    last: int
    label: str = ""  # written into the bar where there is room, and in the tooltip


@dataclass(frozen=True, eq=False)
class Lane:
    """One row of the timeline; its values are not changed after it was handed on."""

    name: str
    colour: str  # #rrggbb
    kind: LaneKind
    values: FloatArray | IntArray | MarkArray | Sequence[Span]
    """(F,) float64, (F,) of Mark, or sequence of Span. For heat a number per frame, NaN where there
    is none; for marks a :class:`Mark` per frame; for bars the stretches."""
    full: float | None = None  # heat: the value shown in the full colour; None takes the largest
    unit: str = ""  # heat: written after the value in the tooltip
    key: str = ""  # what the program calls it; the name where that is empty

    @property
    def id(self) -> str:
        return self.key or self.name

    @cached_property
    def spans(self) -> tuple[Span, ...]:
        return tuple(value for value in self.values if isinstance(value, Span))

    @cached_property
    def numbers(self) -> NDArray[np.generic]:
        """A number for each frame (F,); of marks a bit for each mark."""
        if self.kind == "marks":
            marks = np.asarray(self.values, dtype=np.uint8)
            return np.where(marks > 0, np.left_shift(1, marks), 0).astype(np.uint8)
        return np.asarray(self.values, dtype=np.float64)

    @cached_property
    def full_value(self) -> float:
        if self.full is not None:
            return self.full
        top = float(np.fmax.reduce(self.numbers, initial=np.nan))
        return top if np.isfinite(top) and top > 0 else 1.0

    def columns(self, edges: FloatArray) -> NDArray[np.generic]:
        """Largest value, or all marks, of columns (C,) that lead from one edge to the next.

        Edges (C + 1,) are frames and ascend within 0 to F. A column narrower than a frame shows the
        frame that it lies in; no value is left out.
        """
        reduce = np.bitwise_or if self.kind == "marks" else np.fmax
        first = np.clip(np.floor(edges[:-1]).astype(np.int64), 0, len(self.numbers) - 1)
        last = np.clip(np.ceil(edges[1:]).astype(np.int64), first + 1, len(self.numbers))
        # reduceat over (first, last) pairs; an end behind the last number may not be named
        pairs = np.stack([first, last], axis=1).ravel() - first[0]
        seen = np.append(self.numbers[first[0] : last[-1]], self.numbers[-1:])
        return np.asarray(reduce.reduceat(seen, pairs)[::2])

    def value_text(self, frame: int) -> str:
        """What the lane says about a frame, for a tooltip; empty where it says nothing."""
        if self.kind == "bars":
            labels = [s.label or self.name for s in self.spans if s.first <= frame <= s.last]
            return ", ".join(labels)
        if not 0 <= frame < len(self.values):
            return ""
        value = np.asarray(self.values)[frame]
        if self.kind == "marks":
            return MARK_WORDS[Mark(int(value))]
        return f"{value:.1f} {self.unit}".rstrip() if np.isfinite(value) else "unknown"


_FEWEST_FRAMES = 8.0


@dataclass(frozen=True)
class TimelineScale:
    """Mapping between frames and positions; frame k covers the interval from k to k + 1."""

    frame_count: int = 0
    first: float = 0.0
    last: float = 0.0  # `first` and `last`: borders of what is visible
    left: float = 0.0
    width: float = 1.0
    """`left` and `width`: device-independent pixels. Where the lanes begin, and how wide they
    are."""

    @property
    def visible(self) -> float:
        return max(self.last - self.first, 1e-9)

    def x_of(self, frame: float) -> float:
        """Position of the left border of a frame."""
        return self.left + (frame - self.first) / self.visible * self.width

    def frame_at(self, x: float) -> int:
        """Frame under a position, kept inside the recording."""
        frame = int(np.floor(self.first + (x - self.left) / self.width * self.visible))
        return max(0, min(frame, self.frame_count - 1))

    def whole(self) -> TimelineScale:
        return replace(self, first=0.0, last=float(self.frame_count))

    def zoomed(self, factor: float, x: float) -> TimelineScale:
        """Return the scale `factor` times as large; what is under `x` stays there."""
        share = min(max((x - self.left) / self.width, 0.0), 1.0)
        fixed = self.first + share * self.visible
        visible = min(max(self.visible / factor, _FEWEST_FRAMES), float(self.frame_count))
        return self._starting(fixed - share * visible, visible)

    def moved(self, frames: float) -> TimelineScale:
        """Return the scale moved by `frames`, kept inside the recording."""
        return self._starting(self.first + frames, self.visible)

    def showing(self, frame: int) -> TimelineScale:
        """Return the scale turned like a page where `frame` is not visible."""
        if self.first <= frame and frame + 1 <= self.last:
            return self
        return self._starting(frame - 0.1 * self.visible, self.visible)

    def _starting(self, first: float, visible: float) -> TimelineScale:
        first = min(max(first, 0.0), max(self.frame_count - visible, 0.0))
        return replace(self, first=first, last=first + visible)

    def ticks(self) -> list[int]:
        """Frames to write a number at, at least 70 pixels apart."""
        wanted = 70.0 / self.width * self.visible
        power = 10 ** max(0, int(np.floor(np.log10(max(wanted, 1.0)))))
        step = next(power * m for m in (1, 2, 5, 10, 20) if power * m >= wanted)
        start = int(np.ceil(self.first / step)) * step
        return list(range(start, int(np.ceil(self.last)), step))
