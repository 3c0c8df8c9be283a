"""Curves of the error plot, thinned to what the plot's width can show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray

from ..style.line_styles import LineStyle

__all__ = ["Curve", "LineStyle", "next_crossing", "thinned"]

_HALF_STROKE = 0.4


@dataclass(frozen=True, eq=False)
class Curve:
    """A measure of one limb in one run."""

    name: str
    """The run, as the legend calls it."""
    limb: str
    """The legend's switches work by limb."""
    colour: str
    """#rrggbb, the limb's."""
    style: LineStyle
    """Tells runs apart."""
    frame: IntArray
    """(F,) int64. Ascending."""
    value: FloatArray
    """(F,) float64. NaN leaves a gap."""


def thinned(
    frame: IntArray, value: FloatArray, first: float, last: float, columns: int
) -> tuple[FloatArray, FloatArray]:
    """Points to draw for the frames from `first` to `last` on `columns` columns of pixels.

    Each column keeps its smallest and largest value, so that no peak is lost; a column in which
    nothing is known keeps a NaN, which interrupts the line.

    Returns
    -------
    x, y : (K,) float64
        K is at most about twice the number of columns, or the number of frames if less.
    """
    start = max(int(np.searchsorted(frame, first)) - 1, 0)
    stop = min(int(np.searchsorted(frame, last, side="right")) + 1, len(frame))
    x = frame[start:stop].astype(np.float64)
    y = np.asarray(value[start:stop], dtype=np.float64)
    size = len(x) // max(columns, 1)
    if size < 4:
        return _seen_alone(x, y)
    starts = np.arange(0, len(x), size)
    low = np.fmin.reduceat(y, starts)
    high = np.fmax.reduceat(y, starts)
    return np.repeat(x[starts], 2), np.stack([low, high], axis=1).ravel()


def _seen_alone(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Make a short stroke of each value without neighbours, of which a line shows nothing."""
    known = np.isfinite(y)
    before, after = np.append(False, known[:-1]), np.append(known[1:], False)
    alone = known & ~before & ~after
    times = np.where(alone, 2, 1)
    last = np.cumsum(times)[alone] - 1
    x, y = np.repeat(x, times), np.repeat(y, times)
    x[last] += _HALF_STROKE
    x[last - 1] -= _HALF_STROKE
    return x, y


def next_crossing(
    curves: Sequence[Curve], threshold: float, frame: int, direction: int
) -> int | None:
    """First frame of the next or previous stretch in which any curve is above the threshold.

    Parameters
    ----------
    curves : sequence of Curve
    threshold : float
    frame : int
        Where to start looking.
    direction : int
        1 for forwards, -1 for backwards.

    Returns
    -------
    int or None
        None where there is no such stretch.
    """
    above: set[int] = set()
    for curve in curves:
        with np.errstate(invalid="ignore"):
            above.update(curve.frame[curve.value > threshold].tolist())
    frames = np.array(sorted(above), dtype=np.int64)
    if not len(frames):
        return None
    begins = frames[np.concatenate([[True], np.diff(frames) > 1])]
    wanted = begins[begins > frame] if direction > 0 else begins[begins < frame]
    if not len(wanted):
        return None
    return int(wanted[0] if direction > 0 else wanted[-1])
