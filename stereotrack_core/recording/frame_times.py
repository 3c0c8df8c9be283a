"""Frames from stated times, and values at the frames of another rate.

A file may number its frames from 1, from the start of a part of a trial, or at another rate than
the recording. Its times tell which instant a row belongs to, so they go before its numbers.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.counting import counted
from stereotrack_core.errors import Finding, InputError
from stereotrack_core.tables import LARGEST, finite_number

_SAME = 0.5  # frames by which times and numbers may differ: times are often printed with few digits
_ON_FRAME = 0.1  # frames by which an instant may miss a whole frame and still belong to it
_ON_SAMPLE = 1e-3  # frames by which a frame may miss a sample and still take its values as they are

_CLOCK_SECONDS = 1e6  # seconds beyond which a time is a clock's and not since a recording's start
_SHORTEST_BRIDGE, _LONGEST_BRIDGE = 0.05, 0.1
"""Seconds between known samples over which is interpolated: always, and where samples are so far
apart. A hand that accelerates with 30 m/s² is 9 mm off in the first and 37 mm in the other.
"""

_MOST_FRAMES = 10_000_000
"""Frames that resampling makes at most; more come from a rate or time that cannot be meant."""


TIME_COLUMNS = MappingProxyType(
    {"time": 1.0, "time_s": 1.0, "seconds": 1.0, "timestamp": 1.0, "time_ms": 1e-3}
)
"""Columns of times in tables, and the seconds that their unit has."""


def stated_fps(meta: Mapping[str, Any]) -> float | None:
    """Frames per second that the meta of a run or reference states; None if it states none."""
    fps = meta.get("fps")
    return float(fps) if isinstance(fps, int | float) and 0 < fps < np.inf else None


def stated_time(cells: Mapping[str, str], path: Path, line: int) -> float:
    """Seconds that a row states, its cells by column, or NaN; InputError for no number."""
    for name, seconds in TIME_COLUMNS.items():
        if text := cells.get(name, ""):
            return seconds * finite_number(text, path, line, name)
    return float("nan")


@dataclass(frozen=True, eq=False)
class RowTimes:
    """Where the rows of a file belong."""

    position: FloatArray  # (R,); in frames since time 0, fractional between two frames
    fps: float | None  # frames per second; None if nothing states them
    notes: tuple[Finding, ...] = ()

    def nearest(self, frame: IntArray) -> list[int]:
        """Rows (F,) that are nearest to these frames; there is at least one row."""
        after = np.clip(np.searchsorted(self.position, frame), 0, len(self.position) - 1)
        before = np.maximum(after - 1, 0)
        is_before = abs(self.position[before] - frame) <= abs(self.position[after] - frame)
        return list(np.where(is_before, before, after).tolist())


def row_times(number: IntArray, time: FloatArray, fps: float | None, where: str) -> RowTimes:
    """Positions of rows with the frame numbers (R,), ascending, and times (R,) in seconds.

    `fps` is the rate that the file states. Times decide where they contradict numbers or rate, and
    a note says so. Times that are missing, do not ascend, or are those of a clock are not used.
    """
    by_number = RowTimes(number.astype(np.float64), fps)
    if not len(number) or not np.isfinite(time).all():
        return by_number
    if (np.diff(time) <= 0.0).any():
        return _unused(by_number, where, "its times do not ascend with its frame numbers")
    own_rate = fps if len(time) < 2 else _rate_of(number, time, fps)
    if abs(time[0]) > _CLOCK_SECONDS:
        return _unused(replace(by_number, fps=own_rate), where, "its times are those of a clock")
    if own_rate is None:
        return by_number
    position: FloatArray = np.asarray(time * own_rate)
    if (abs(position) > LARGEST).any():
        what = f"the time {time[abs(position).argmax()]:g} s is no frame at {own_rate:g} Hz"
        remedy = "Write times in seconds since the first frame of the recording."
        raise InputError(what, where, remedy)
    notes: list[Finding] = []
    if fps is not None and own_rate != fps:
        what = f"it states {fps:g} frames per second, but its times have {own_rate:.6g}"
        notes.append(Finding("warning", where, what, "The times are used."))
    shift = position - number
    if np.ptp(shift) <= 2.0 * _SAME:  # printed with few digits, so as even as the numbers are
        middle = float(np.median(shift))
        whole = round(middle)
        shift[:] = whole if abs(middle - whole) <= _ON_FRAME else middle
        position = number + shift
    if (abs(position - number) > _ON_FRAME).any():
        notes.append(_renumbered(number, position, time, where))
    return RowTimes(position, own_rate, tuple(notes))


def _unused(rows: RowTimes, where: str, why: str) -> RowTimes:
    note = Finding("warning", where, why, "The frame numbers are used.")
    return replace(rows, notes=(*rows.notes, note))


def _renumbered(number: IntArray, position: FloatArray, time: FloatArray, where: str) -> Finding:
    first = abs(position - number).argmax() if position[0] == number[0] else 0
    usual = bool((position == number - 1).all()) and position[0] == 0
    stated = f"its row of frame {number[first]} has the time {time[first]:g} s"
    what = f"{stated}, which is frame {position[first]:.4g} counted from 0"
    return Finding("note" if usual else "warning", where, what, "The times are used.")


def _rate_of(number: IntArray, time: FloatArray, stated: float | None) -> float | None:
    """Frames per second: the stated rate if the times have it, else that of the times."""

    def fits(rate: float) -> bool:
        passed = (time - time[0]) * rate
        return bool((abs(number - number[0] - passed) <= _SAME).all())

    mean = float((number[-1] - number[0]) / (time[-1] - time[0]))
    whole = round(mean)
    for rate in (stated, float(whole), whole * 1000.0 / 1001.0, mean):
        if rate is not None and rate > 0.0 and fits(rate):
            return rate
    # times with a jump, or of uneven frames
    return float(1.0 / np.median(np.diff(time))) if stated is None else stated


def on_frames(rows: RowTimes, points: FloatArray, where: str) -> tuple[IntArray, FloatArray]:
    """Whole frames and the landmarks (F, K, 3) there; interpolated if rows are between frames."""
    frame = np.rint(rows.position).astype(np.int64)
    even = (abs(rows.position - frame) <= _ON_FRAME).all() and (np.diff(frame) > 0).all()
    if even or rows.fps is None:
        return frame, points
    return at_rate(rows.position, points, rows.fps, rows.fps, where)


def same_rate(fps: float, other: float, frame: IntArray) -> bool:
    """Whether these frames have the same numbers at both rates."""
    return bool(abs(other / fps - 1.0) * (abs(frame).max(initial=0) + 1) <= _ON_FRAME)


def at_rate(
    frame: IntArray | FloatArray, points: FloatArray, own: float, fps: float, where: str
) -> tuple[IntArray, FloatArray]:
    """Frames of the rate `fps` near known samples of the rate `own`, and the landmarks (F, K, 3).

    Between samples landmarks are interpolated linearly, but neither over gaps nor beyond the ends.
    InputError if the rates are too different; `where` names the source.
    """
    position = np.asarray(frame * (fps / own))
    near = np.rint(position)
    near = near[abs(position - near) <= _ON_SAMPLE]
    first, last = np.ceil(position[:-1]), np.floor(position[1:])
    bridged = np.diff(position) <= _bridge(own, fps)
    count = np.where(bridged, np.maximum(last - first + 1.0, 0.0), 0.0)
    if not count.sum() <= _MOST_FRAMES or not (abs(position) <= LARGEST).all():
        what = f"its frame rate makes more than {_MOST_FRAMES:,} frames"
        raise InputError(what, where, "Correct the frame rate or the times that the file states.")
    counts = count.astype(np.int64)
    start = np.repeat(np.cumsum(counts) - counts, counts)
    between = np.repeat(first, counts) + np.arange(counts.sum()) - start
    at = np.unique(np.concatenate([near, between])).astype(np.int64)
    return at, values_at(frame, points, own, fps, at)


def values_at(
    frame: IntArray | FloatArray, values: FloatArray, own: float, fps: float, at: IntArray
) -> FloatArray:
    """Values (F, K, C) of the rate `own` at the frames `at` of the rate `fps`; NaN where unknown.

    As :func:`at_rate` interpolates; a value is known if all of its C numbers are.
    """
    position, longest = np.asarray(frame * (fps / own)), _bridge(own, fps)
    result: FloatArray = np.full((len(at), *values.shape[1:]), np.nan)
    for k in range(values.shape[1]):
        known: BoolArray = np.asarray(np.isfinite(values[:, k]).all(axis=1))
        if not known.any():
            continue
        own_places = position[known]
        ends = np.concatenate([[-np.inf], own_places, [np.inf]])
        after = np.searchsorted(own_places, at)
        before, next_one = ends[after], ends[after + 1]
        hit = np.minimum(at - before, next_one - at) <= _ON_SAMPLE
        inside = hit | (next_one - before <= longest)
        for axis, column in enumerate(values[known, k].T):
            result[inside, k, axis] = np.interp(at[inside], own_places, column)
    return result


def resampled_note(own: float, fps: float, where: str) -> Finding:
    """The note that values were taken at the frames of another rate."""
    what = f"it has {own:.6g} frames per second, the recording {fps:.6g}"
    return Finding("note", where, what, "It was resampled by time.")


def _bridge(own: float, fps: float) -> float:
    """Frames of the rate `fps` over which samples of the rate `own` are interpolated."""
    return fps * min(max(1.01 / own, _SHORTEST_BRIDGE), _LONGEST_BRIDGE)


def outside_notes(frame: IntArray, count: int, where: str) -> Iterator[Finding]:
    """Notes about frames before and after those of a recording of so many."""
    for outside, side in (
        (int((frame < 0).sum()), "before"),
        (int((frame >= count).sum()), "after"),
    ):
        if outside:
            longer = f"it is longer than the recording of {counted(count, 'frame')}"
            what = f"{longer}: {outside} of its {len(frame)} frames lie {side} it"
            yield Finding("note", where, what, "They are left out.")
