"""Clicks as tables with a row for each frame: DLTdv, Argus and XMALab.

All three have columns for each point in each camera and no column for the frame: the n-th row is
frame n - 1 of the recording. They differ in their columns' names and in what a pixel is:

- ``dltdv``: ``pt1_cam1_X``; the centre of the top-left pixel is (1, 1), y points down. That is
  DLTdv8; DLTdv 5 to 7 count y from the bottom.
- ``argus``: ``head_cam_1_x``; the centre of the top-left pixel is (0, height): y points up.
- ``xmalab``: ``head_cam1_X``; the centre of the top-left pixel is (0, 0), y points down. These are
  the choices of its dialog that are made beforehand: with a header, from 0, y down, distorted.

Cameras are numbered in the recording's order, points in the project's. A file of the same name
with ``.json`` behind it states both, for people and for reading it again. The tables have no column
for how a landmark is seen, or for what is outside the image: neither comes back.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

from stereotrack_core.annotation.click import Click
from stereotrack_core.atomic import write_files
from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.interop.label_source import PLACES_ALONE, Labels, LabelSource, pictures_of
from stereotrack_core.plain_data import Kind, check_kind
from stereotrack_core.reading import TABLE_BYTES, read_json
from stereotrack_core.recording.description import Recording
from stereotrack_core.tables import csv_text, read_cells


@dataclass(frozen=True)
class PointTable:
    """How one of the programs writes its tables."""

    program: str
    column: str
    """Name of a column, with ``{point}``, ``{number}``, ``{camera}`` and ``{axis}``."""
    pattern: re.Pattern[str]
    """The same to be read: point, camera's number and axis."""
    first_pixel: int
    """Number of the first pixel of a row, whose centre it is."""
    upwards: bool
    """Whether y points up, from the edge below the last row of pixels."""
    axes: str = "XY"
    numbered: bool = False
    """Whether points have numbers instead of names."""

    def place(self, pixel: tuple[float, float], camera: Camera) -> tuple[float, float]:
        """Ours in theirs."""
        x, y = pixel
        return x + self.first_pixel, camera.height - y if self.upwards else y + self.first_pixel

    def pixel(self, place: tuple[float, float], camera: Camera) -> tuple[float, float]:
        """Theirs in ours."""
        x, y = place
        return x - self.first_pixel, camera.height - y if self.upwards else y - self.first_pixel


POINT_TABLES: Mapping[str, PointTable] = MappingProxyType(
    {
        "dltdv": PointTable(
            "DLTdv",
            "pt{number}_cam{camera}_{axis}",
            re.compile(r"(pt\d+)_cam(\d+)_([XY])"),
            1,
            upwards=False,
            numbered=True,
        ),
        "argus": PointTable(
            "Argus",
            "{point}_cam_{camera}_{axis}",
            re.compile(r"(.+)_cam_(\d+)_([xy])"),
            0,
            upwards=True,
            axes="xy",
        ),
        "xmalab": PointTable(
            "XMALab",
            "{point}_cam{camera}_{axis}",
            re.compile(r"(.+)_cam(\d+)_([XY])"),
            0,
            upwards=False,
        ),
    }
)
"""By the name of the format; a header is of the first whose pattern it has."""

_BESIDE: Kind = {"cameras": {str: str}, "points": {str: str}}


def write_points(
    path: Path,
    clicks: Iterable[Click],
    recording: Recording,
    landmarks: Sequence[str],
    form: str,
    frames: int = 0,
) -> int:
    """Write clicks of all cameras, and ``<path>.json``; the number of clicks that have a place.

    `form` is one of :data:`POINT_TABLES`. The table has `frames` rows, more where a click needs it.

    InputError where a file cannot be written, or the recording has no such camera.
    """
    table = POINT_TABLES[form]
    cameras = list(recording.cameras)
    columns = [
        table.column.format(point=name, number=number, camera=camera, axis=axis)
        for number, name in enumerate(landmarks, start=1)
        for camera in range(1, len(cameras) + 1)
        for axis in table.axes
    ]
    width, count = len(columns), 0
    rows: dict[int, list[str]] = {}
    for camera, frame, found in pictures_of(clicks, landmarks, recording, path):
        row = rows.setdefault(frame, ["NaN"] * width)
        for name, click in found.items():
            if click.position is None:
                continue
            column = 2 * (landmarks.index(name) * len(cameras) + cameras.index(camera.name))
            place = table.place(click.position, camera)
            row[column : column + 2] = [repr(float(value)) for value in place]
            count += 1
    last = max(frames, max(rows, default=-1) + 1)
    empty = ["NaN"] * width
    text = csv_text(columns, (rows.get(frame, empty) for frame in range(last)))
    notes = _notes(table, cameras, landmarks)
    beside = path.with_name(path.name + ".json")
    write_files({path: text, beside: json.dumps(notes, indent=2, ensure_ascii=False) + "\n"})
    return count


def _notes(
    table: PointTable, cameras: Sequence[str], landmarks: Sequence[str]
) -> dict[str, str | dict[str, str]]:
    first = table.first_pixel
    corner = f"({first}, height)" if table.upwards else f"({first}, {first})"
    direction = "up" if table.upwards else "down"
    return {
        "program": table.program,
        "pixels": f"of the raw image; the centre of the top-left one is {corner}, y points "
        f"{direction}",
        "rows": "row n is frame n - 1 of the recording",
        "cameras": {str(number): name for number, name in enumerate(cameras, start=1)},
        "points": {
            f"pt{number}" if table.numbered else name: name
            for number, name in enumerate(landmarks, start=1)
        },
    }


def point_table_of(header: Sequence[str]) -> str:
    """Which of the formats a file has whose first line this is; empty where none."""
    for form, table in POINT_TABLES.items():
        if header and all(table.pattern.fullmatch(name) for name in header):
            return form
    return ""


def read_points(source: LabelSource) -> Labels:
    """Read the clicks of all cameras.

    Cameras and points are those of the file beside it, where there is one; else cameras have the
    recording's order, and points their names (``pt1`` of DLTdv means nothing: state it).

    InputError where the file cannot be read, the recording has fewer cameras, or no point is known.
    """
    path = source.path
    lines = read_cells(path, headers=1)
    table = POINT_TABLES[point_table_of(lines[0])]
    cameras, points = _stated_beside(path, source)
    places: dict[tuple[str, str], dict[str, int]] = {}
    for column, name in enumerate(lines[0]):
        point, number, axis = _parts(table, name)
        if number not in cameras:
            raise InputError(
                f"the file has a camera {number}, the recording has {len(cameras)}",
                where=str(path),
                remedy="Remove its columns, or add the camera to the recording.",
            )
        if source.camera is not None and cameras[number] != source.camera_of("", str(path)):
            continue
        own = places.setdefault((points.get(point, point), cameras[number]), {})
        own[axis.lower()] = column

    def read(row: tuple[int, Sequence[str]], known: Mapping[str, str]) -> list[Click]:
        line, cells = row
        clicks = []
        for (point, name), columns in places.items():
            if point in known and len(columns) == 2:
                x, y = (_value(cells, columns[axis], path, line) for axis in "xy")
                if math.isfinite(x) and math.isfinite(y):
                    pixel = table.pixel((x, y), source.recording.cameras[name])
                    clicks.append(Click(line - 2, name, known[point], pixel, origin="imported"))
        return clicks

    rows = enumerate(lines[1:], start=2)
    found = source.labels((point for point, _ in places), rows, read)
    return replace(found, unstated=PLACES_ALONE)


def _parts(table: PointTable, name: str) -> tuple[str, str, str]:
    match = table.pattern.fullmatch(name)
    assert match is not None  # noqa: S101 - the whole header was looked at
    return match[1], match[2], match[3]


def _stated_beside(path: Path, source: LabelSource) -> tuple[dict[str, str], dict[str, str]]:
    """Cameras by number, and landmarks by the file's points."""
    cameras = {str(k): name for k, name in enumerate(source.recording.cameras, start=1)}
    beside = path.with_name(path.name + ".json")
    if not beside.is_file():
        return cameras, {}
    remedy = "Delete it, or export the clicks again."
    content = read_json(beside, TABLE_BYTES, remedy)
    check_kind(content, _BESIDE, str(beside), remedy)
    stated = {**cameras, **(content.get("cameras") or {})}
    for name in stated.values():
        if name not in source.recording.cameras:
            raise InputError(
                f"the recording has no camera {name!r}",
                where=str(beside),
                remedy=f"Its cameras are {', '.join(source.recording.cameras)}.",
            )
    points = content.get("points") or {}
    return stated, {theirs: ours for theirs, ours in points.items() if ours}


def _value(cells: Sequence[str], column: int, path: Path, line: int) -> float:
    text = cells[column] if column < len(cells) else ""
    try:
        return float(text) if text else math.nan
    except ValueError:
        raise InputError(
            f"line {line}: {text!r} is not a number",
            where=str(path),
            remedy="Write pixels as a number, or NaN.",
        ) from None
