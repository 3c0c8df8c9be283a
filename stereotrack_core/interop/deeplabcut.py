"""DeepLabCut's tables of labels and of predictions: one file for each camera.

CSV; HDF5 (:mod:`deeplabcut_hdf5`) is read only: DeepLabCut itself makes it of the CSV, by
``deeplabcut.convertcsv2h5``.

Labels have the pictures' paths in the first column (or in the first three), predictions the number
of the frame and a likelihood for each point. Coordinates are raw-image pixels, (0, 0) the centre of
the first one. The table has no column for how a landmark is seen: one that is guessed comes back as
seen, and one that is outside the image has no values, like one that nobody has labelled.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple, TypeAlias

from stereotrack_core.annotation.click import Click
from stereotrack_core.atomic import write_files
from stereotrack_core.counting import typed_number
from stereotrack_core.errors import InputError
from stereotrack_core.interop import label_source
from stereotrack_core.interop.deeplabcut_hdf5 import StoredTable, stored_table
from stereotrack_core.tables import csv_text, read_cells

# Not read by sleap-io (0.9.5): it gives no labels and no complaint for a CSV whose pictures are not
# beside it, or of predictions, and cannot open the HDF5 files.

_NOT_IN_FILES = frozenset('/\\:*?"<>|').union(map(chr, range(32)))
"""Signs that some system does not allow in names, or takes for the way to another folder."""

_SCORER = "stereotrack"
_WORDS = ("nan", "NaN", "inf", "-inf")
_LEAST_LIKELIHOOD = 0.6  # predictions below it are left out
_HEADERS = ("scorer", "individuals", "bodyparts", "coords")
_NUMBERS = ("x", "y", "likelihood")


Row: TypeAlias = tuple[str, Sequence[str], Sequence[str | float]]
"""Place of a row in the file, the cells that name its picture, and those of the columns."""


class DeepLabCutTable(NamedTuple):
    """Cells of a table."""

    columns: Sequence[tuple[str, ...]]
    """Individual (empty if there is one alone), body part and coordinate of each column."""
    rows: Sequence[Row]

    def points(self, row: Row) -> Iterator[tuple[str, str, float, float, float]]:
        """Points of a row with likelihood, NaN where empty; InputError if a cell is no number."""
        found: dict[tuple[str, str], dict[str, float]] = {}
        for cell, (individual, part, coordinate) in zip(row[2], self.columns, strict=True):
            if coordinate in _NUMBERS:
                if (number := _number("nan" if cell == "" else cell)) is None:
                    remedy = "Write pixels as a number, or leave the value empty."
                    what = f"{coordinate} of {part} is {cell!r}"
                    raise InputError(what, where=row[0], remedy=remedy)
                found.setdefault((individual, part), {})[coordinate] = number
        for (individual, part), own in found.items():
            x, y = own.get("x", math.nan), own.get("y", math.nan)
            yield individual, part, x, y, own.get("likelihood", 1.0)


def read_table(path: Path, remedy: str) -> DeepLabCutTable:
    """The table of a CSV or HDF5 file; InputError where it cannot be read."""
    if path.suffix.lower() == ".h5":
        return table_of_stored(path, stored_table(path))
    return table_of(path, read_cells(path, headers=3), remedy)


def table_of_stored(path: Path, table: StoredTable) -> DeepLabCutTable:
    """The table of an HDF5 file."""
    columns = [(*("",) * (4 - len(name)), *name[1:]) for name in table.columns]
    rows: list[Row] = [
        (f"{path}, row {'/'.join(named)}", named, values)
        for named, values in zip(table.rows, table.values.tolist(), strict=True)
    ]
    return DeepLabCutTable(columns, rows)


def table_of(path: Path, lines: Sequence[Sequence[str]], remedy: str) -> DeepLabCutTable:
    """The table of the lines of a file; InputError where those before the numbers do not fit."""
    header = {line[0]: line for line in lines[:4] if line and line[0] in _HEADERS}
    if "bodyparts" not in header or "coords" not in header:
        what = "the lines bodyparts and coords are missing"
        raise InputError(what, where=str(path), remedy=remedy)
    coords, parts = header["coords"], header["bodyparts"]
    people = header.get("individuals", [""] * len(coords))
    if not len(people) == len(parts) == len(coords):
        what = "the lines before the numbers are not equally long"
        raise InputError(what, where=str(path), remedy=remedy)
    first = next((k for k, name in enumerate(coords) if name in _NUMBERS), len(coords))
    columns = list(zip(people, parts, coords, strict=True))[first:]
    rows: list[Row] = []
    for number, line in enumerate(lines[len(header) :], start=len(header) + 1):
        if any(line):
            cells = [*line[first:], *[""] * len(columns)][: len(columns)]
            rows.append((f"{path}, line {number}", line[:first], cells))
    return DeepLabCutTable(columns, rows)


def is_deeplabcut(lines: Sequence[Sequence[str]]) -> bool:
    """Whether a CSV begins as DeepLabCut's do."""
    return bool(lines) and bool(lines[0]) and lines[0][0] == "scorer"


def read_deeplabcut(source: label_source.LabelSource) -> label_source.Labels:
    """Read labels, or predictions of at least 0.6, of one camera or of those that pictures name."""
    path = source.path
    table = read_table(path, "Use a .csv file written by DeepLabCut.")
    if len({individual for individual, _, _ in table.columns} - {""}) > 1:
        what = "the file contains several individuals"
        raise InputError(what, where=str(path), remedy="Export the labels of one person only.")
    place_of_row = places_of_rows((named for _, named, _ in table.rows), source)

    def read(row: Row, known: Mapping[str, str]) -> Iterator[Click]:
        if (place := place_of_row(row[1], row[0])) is None:
            return
        for _, part, x, y, likelihood in table.points(row):
            likely = part in known and likelihood >= _LEAST_LIKELIHOOD
            if likely and math.isfinite(x) and math.isfinite(y):
                yield Click(*place, known[part], (x, y), origin="imported")

    parts = (part for _, part, coordinate in table.columns if coordinate in _NUMBERS)
    return replace(source.labels(parts, table.rows, read), unstated=label_source.PLACES_ALONE)


def write_deeplabcut(
    path: Path, clicks: Iterable[Click], landmarks: Sequence[str]
) -> dict[Path, int]:
    """Write clicks as labels: one file, or with several cameras one for each, named after it.

    InputError where a file cannot be written, or a camera has a name that no file can have; then
    all files stay as they were. Returns how many labels are in each file.
    """
    by_camera: dict[str, list[Click]] = {}
    for click in clicks:
        if not click.deleted:
            by_camera.setdefault(click.camera, []).append(click)
    files = {file_of_camera(path, camera): own for camera, own in by_camera.items()}
    if len(files) < 2:
        files = {path: next(iter(files.values()), [])}
    write_files({file: _content(own, landmarks) for file, own in files.items()})
    return {file: sum(click.position is not None for click in own) for file, own in files.items()}


def _content(clicks: Iterable[Click], landmarks: Sequence[str]) -> str:
    """The labels of one camera."""
    by_picture: dict[tuple[int, str], dict[str, tuple[float, float]]] = {}
    for click in clicks:
        if click.position is not None:
            by_picture.setdefault((click.frame, click.camera), {})[click.landmark] = click.position
    twice = [name for name in landmarks for _ in "xy"]
    rows = [["bodyparts", *twice], ["coords", *["x", "y"] * len(landmarks)]]
    for (frame, camera), places in sorted(by_picture.items()):
        pixels = [places.get(name, ("", "")) for name in landmarks]
        cells = [repr(float(one)) if one != "" else "" for pixel in pixels for one in pixel]
        rows.append([f"labeled-data/{camera}/img{frame:06d}.png", *cells])
    return csv_text(["scorer", *[_SCORER] * len(twice)], rows)


def file_of_camera(path: Path, camera: str) -> Path:
    """File of one camera, where those of several are written: ``labels_S.csv`` for ``labels.csv``.

    InputError where the camera's name is none that a file or a folder can have.
    """
    if camera.strip() in ("", ".", "..") or any(sign in _NOT_IN_FILES for sign in camera):
        what = f"the camera name {camera!r} cannot be used as a folder name"
        remedy = "Export the clicks as csv or coco, or rename the camera."
        raise InputError(what, where=str(path), remedy=remedy)
    return path.with_name(f"{path.stem}_{camera}{path.suffix}")


def places_of_rows(
    rows: Iterable[Sequence[str]], source: label_source.LabelSource
) -> Callable[[Sequence[str], str], tuple[int, str] | None]:
    """Gives frame and camera of a row by its first cells: its number, or its picture's path.

    The function that is given takes the cells and what it is asked for. It gives None for a picture
    of another camera than the stated one, and raises InputError where they cannot be told.
    """
    pictures = ("/".join(filter(None, cells)) for cells in rows)
    places = label_source.PicturePlaces(source, [one for one in pictures if _number(one) is None])

    def place(cells: Sequence[str], where: str) -> tuple[int, str] | None:
        text = "/".join(filter(None, cells))
        if (frame := _number(text)) is None:
            return places.of(text, where)
        own = source.camera_of(source.path.name, str(source.path))
        return label_source.checked_frame(frame, where=where), own

    return place


def _number(text: str | float) -> float | None:
    try:
        return float(text) if text in _WORDS or isinstance(text, float) else typed_number(text)
    except ValueError:
        return None
