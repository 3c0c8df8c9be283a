"""Read and write ``segments.csv``: named stretches of frames, half-open."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError
from stereotrack_core.recording.csv_table import csv_text, read_rows, whole_number
from stereotrack_core.recording.description import Segment

COLUMNS = ("segment", "first", "end")


def read_segments(path: Path) -> tuple[Segment, ...]:
    """Segments in the file's order.

    Raises
    ------
    InputError
        When the file cannot be read or a segment has no name or ends before it begins.
    """
    segments = []
    for line, cells in read_rows(path, COLUMNS):
        first = whole_number(cells["first"], path, line, "first")
        end = whole_number(cells["end"], path, line, "end")
        if not cells["segment"]:
            raise InputError(
                f"the segment in line {line} has no name", where=str(path), remedy="Give it a name."
            )
        if not 0 <= first < end:
            raise InputError(
                f"segment {cells['segment']!r} in line {line} goes from {first} to {end}",
                where=str(path),
                remedy="Write 0 <= first < end. The frame `end` is not part of the segment.",
            )
        segments.append(Segment(cells["segment"], first, end))
    return tuple(segments)


def write_segments(path: Path, segments: Iterable[Segment]) -> None:
    """Write segments so that :func:`read_segments` gives them again."""
    rows = [(segment.name, segment.first, segment.end) for segment in segments]
    write_file(path, csv_text(COLUMNS, rows))
