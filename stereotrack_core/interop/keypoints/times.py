"""Frames of keypoint tables whose rows state their times, which go before frame numbers."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stereotrack_core.interop.keypoints.people import FileRow
from stereotrack_core.recording.frame_times import TIME_COLUMNS, row_times, same_rate, stated_time
from stereotrack_core.tables import read_cells, whole_number

_ROUNDED = 1e-3
"""Frames by which times may be rounded."""


@dataclass(frozen=True)
class TableTimes:
    """Frames of the recording by the frame numbers of a table; None between two frames."""

    frames: dict[int, int | None]
    notes: tuple[str, ...] = ()
    """What was decided, as clauses."""

    def placed(self, rows: Iterable[FileRow]) -> Iterator[FileRow]:
        """The rows at the recording's frames; those between two frames are left out."""
        for row in rows:
            if (frame := self.frames.get(row[0], row[0])) is not None:
                yield (frame, *row[1:])


def table_times(path: Path, fps: float) -> TableTimes:
    """Frames by the times of a table (.csv) in a recording of that rate; none without times.

    Of a table of another rate, the row nearest to each frame is taken, if it is at most half a
    frame of either rate away.
    """
    times = _times(path) if path.suffix.lower() == ".csv" else {}
    number = np.array(sorted(times), dtype=np.int64)
    rows = row_times(number, np.array([times[one] for one in number.tolist()]), None, str(path))
    notes = tuple(f"{note.what}. {note.remedy.rstrip('.')}" for note in rows.notes)
    if rows.fps is None or len(number) < 2:
        return TableTimes({}, notes)
    position = rows.position
    if not same_rate(rows.fps, fps, number):
        position = position * (fps / rows.fps)
        notes += (
            f"it has {rows.fps:.6g} frames per second, the recording {fps:.6g}: each frame has the "
            "row that is nearest in time",
        )
    frame = np.rint(position).astype(np.int64)
    away = abs(position - frame)
    nearest: dict[int, int] = {}
    for k in np.argsort(away, kind="stable").tolist():
        if away[k] <= 0.5 * min(1.0, fps / rows.fps) + _ROUNDED:
            nearest.setdefault(int(frame[k]), k)
    kept = set(nearest.values())
    return TableTimes(
        {n: int(frame[k]) if k in kept else None for k, n in enumerate(number.tolist())}, notes
    )


def _times(path: Path) -> dict[int, float]:
    """Seconds by frame number, or by row if there are no numbers; empty without times."""
    lines = read_cells(path)
    header = lines[0] if lines else []
    if not any(name in header for name in TIME_COLUMNS):
        return {}
    found: dict[int, float] = {}
    filled = [(line, cells) for line, cells in enumerate(lines[1:], start=2) if any(cells)]
    for row, (line, values) in enumerate(filled):
        cells = dict(zip(header, values, strict=False))
        frame = whole_number(cells["frame"], path, line, "frame") if "frame" in cells else row
        found.setdefault(frame, stated_time(cells, path, line))
    return found
