"""Predicted keypoints as this program writes them, ``frame,view,keypoint,x,y,confidence``.

Columns ``person`` (number or name) and ``source`` may follow; a column ``landmark`` may stand for
``keypoint`` and ``camera`` for ``view``. A view means its reference picture. Pixels are those of
raw pictures.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from stereotrack_core.atomic import write_file
from stereotrack_core.interop.keypoints.people import FileRow, Who
from stereotrack_core.interop.keypoints.source import KeypointSource
from stereotrack_core.interop.label_source import PicturePlaces, checked_frame
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.keypoints import Keypoints, rows_of
from stereotrack_core.tables import csv_text, finite_number, read_cells, read_rows, whole_number

COLUMNS = ("frame", "view", "keypoint", "x", "y", "confidence", "person", "source")
_NEEDED = (("frame",), ("view", "camera"), ("keypoint", "landmark"), ("x",), ("y",))


def is_table(header: list[str]) -> bool:
    """Whether a CSV file with this first line is one."""
    return all(any(name in header for name in names) for names in _NEEDED)


def read_table(source: KeypointSource) -> Iterator[FileRow]:
    """Rows of a table; InputError where it cannot be read or names no camera of the recording."""
    path, header = source.path, read_cells(source.path)[0]
    frame, view, keypoint, x, y = (
        next(name for name in names if name in header) for names in _NEEDED
    )
    others = [name for name in COLUMNS[5:] if name in header]
    lines = list(read_rows(path, (frame, view, keypoint, x, y, *others)))
    places = PicturePlaces(source.labels, {f"{cells[view]}/*" for _, cells in lines})
    cameras: dict[str, str | None] = {}
    for line, cells in lines:
        if (name := cells[view]) not in cameras:
            cameras[name] = places.camera(f"{name}/*", f"{path}, line {line}")
        if (camera := cameras[name]) is None:
            continue
        numbers = [
            finite_number(cells[name], path, line, name) if cells[name] else float("nan")
            for name in (x, y)
        ]
        sure, person, told = (cells.get(name, "") for name in COLUMNS[5:])
        yield (
            checked_frame(
                whole_number(cells[frame], path, line, frame), where=f"{path}, line {line}"
            ),
            camera,
            cells[keypoint],
            numbers[0],
            numbers[1],
            finite_number(sure, path, line, "confidence") if sure else 1.0,
            source.detector or told or source.name,
            Who(0, person.strip()),
        )


def write_table(path: Path, keypoints: Keypoints, recording: Recording) -> None:
    """Write keypoints so that :func:`read_table` gives them again, to a thousandth of a pixel."""
    views = {view.image.camera: view.name for view in recording.views}
    rows = (
        (frame, views.get(camera, camera), name, f"{x:.3f}", f"{y:.3f}", sure, person, told)
        for frame, camera, name, x, y, sure, told, person in rows_of(keypoints)
    )
    write_file(path, csv_text(COLUMNS, rows))
