"""Which frames the timeline shows, and where."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stereotrack_core.arrays import FloatArray

_FEWEST_FRAMES = 8.0


@dataclass(frozen=True)
class TimelineScale:
    """Mapping between frames and positions; frame k covers the interval from k to k + 1."""

    frame_count: int = 0
    """Frames of the recording."""
    first: float = 0.0
    last: float = 0.0
    """`first` and `last`: borders of what is visible."""
    left: float = 0.0
    width: float = 1.0
    """`left` and `width`: device-independent pixels. Where the lanes begin, and how wide they
    are."""

    @property
    def visible(self) -> float:
        """How many frames are visible."""
        return max(self.last - self.first, 1e-9)

    @property
    def is_whole(self) -> bool:
        """Whether all frames are visible."""
        return self.first <= 0.0 and self.last >= self.frame_count

    def x_of(self, frame: float) -> float:
        """Position of the left border of a frame."""
        return self.left + (frame - self.first) / self.visible * self.width

    def frame_at(self, x: float) -> int:
        """Frame under a position, kept inside the recording."""
        frame = int(np.floor(self.first + (x - self.left) / self.width * self.visible))
        return max(0, min(frame, self.frame_count - 1))

    def edges(self, columns: int) -> FloatArray:
        """Frames at the borders of `columns` columns (columns + 1,)."""
        return np.linspace(self.first, self.last, columns + 1)

    def whole(self) -> TimelineScale:
        """Return the scale that shows everything."""
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

    def ticks(self, smallest_gap: float = 70.0) -> list[int]:
        """Frames to write a number at, at least `smallest_gap` pixels apart."""
        wanted = smallest_gap / self.width * self.visible
        power = 10 ** max(0, int(np.floor(np.log10(max(wanted, 1.0)))))
        step = next(power * m for m in (1, 2, 5, 10, 20) if power * m >= wanted)
        start = int(np.ceil(self.first / step)) * step
        return list(range(start, int(np.ceil(self.last)), step))
