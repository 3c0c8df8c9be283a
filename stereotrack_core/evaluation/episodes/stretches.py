"""Stretches of frames in which a value is high: hysteresis, bridged gaps, a least length."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class Stretch:
    """Frames from the first to the last one, both included, and where the value is highest."""

    first: int
    last: int
    peak: float
    peak_frame: int

    def overlap(self, other: Stretch) -> int:
        """Number of frames that both have."""
        return max(0, min(self.last, other.last) - max(self.first, other.first) + 1)


def high_stretches(
    frame: IntArray, value: FloatArray, enter: float, leave: float, least: int, bridge: int
) -> list[Stretch]:
    """Stretches in which a value is high.

    One begins where the value exceeds `enter`, reaches back and forth to where it falls below
    `leave`, and is joined to the next one over gaps of at most `bridge` frames. NaN is not high.

    Parameters
    ----------
    frame : (F,) int64, ascending
    value : (F,) float64
    enter, leave : float
        `leave` is at most `enter`.
    least : int
        Frames that a stretch has at least.
    bridge : int
        Frames of a gap that is bridged at most; frames that are absent count as a gap.
    """
    with np.errstate(invalid="ignore"):
        seed, high = value > enter, value > leave
    found: list[list[int]] = []
    for run in _runs(high, frame):
        if seed[run[0] : run[1] + 1].any():
            gap = int(frame[run[0]] - frame[found[-1][1]] - 1) if found else bridge + 1
            if gap <= bridge:
                found[-1][1] = run[1]
            else:
                found.append(run)
    return [
        _stretch(frame, value, first, last)
        for first, last in found
        if frame[last] - frame[first] + 1 >= least
    ]


def _runs(high: BoolArray, frame: IntArray) -> list[list[int]]:
    """First and last index of each run of successive frames that are high."""
    places = np.flatnonzero(high)
    if not len(places):
        return []
    breaks = np.flatnonzero(np.diff(frame[places]) > 1) + 1
    return [[int(part[0]), int(part[-1])] for part in np.split(places, breaks)]


def _stretch(frame: IntArray, value: FloatArray, first: int, last: int) -> Stretch:
    peak = first + int(np.nanargmax(value[first : last + 1]))
    return Stretch(int(frame[first]), int(frame[last]), float(value[peak]), int(frame[peak]))
