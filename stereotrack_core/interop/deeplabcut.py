"""DeepLabCut's tables of labels and of predictions: one file for each camera.

CSV; HDF5 is read only: DeepLabCut itself makes it of the CSV, by ``deeplabcut.convertcsv2h5``. It
is a table of pandas with the key ``df_with_missing``, of the format ``fixed`` or ``table``, read by
h5py alone, which runs nothing that a file may hold. The format ``table`` keeps names of columns as
a pickle, of which only texts, numbers, lists and tuples are read; anything else is refused, as it
could run a program.

Labels have the pictures' paths in the first column (or in the first three), predictions the number
of the frame and a likelihood for each point; several individuals are people, whose names hold over
all frames. Coordinates are raw-image pixels, (0, 0) the centre of
the first one. The table has no column for how a landmark is seen: one that is guessed comes back as
seen, and one that is outside the image has no values, like one that nobody has labelled.
"""

import io
import math
import pickle
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple, NoReturn, TypeAlias

import numpy as np

from stereotrack_core.annotation.click import Click
from stereotrack_core.arrays import FloatArray
from stereotrack_core.atomic import write_files
from stereotrack_core.counting import typed_number
from stereotrack_core.errors import InputError
from stereotrack_core.interop import label_source
from stereotrack_core.interop.keypoints.source import FileRow, KeypointSource, Who
from stereotrack_core.limited_process import read_apart
from stereotrack_core.reading import check_file, decoding
from stereotrack_core.tables import csv_text, read_cells
from stereotrack_core.versions import check_library

# Not read by sleap-io (0.9.5): it gives no labels and no complaint for a CSV whose pictures are not
# beside it, or of predictions, and cannot open the HDF5 files.

_NOT_IN_FILES = frozenset('/\\:*?"<>|').union(map(chr, range(32)))
"""Signs that some system does not allow in names, or takes for the way to another folder."""

_SCORER = "stereotrack"
_WORDS = ("nan", "NaN", "inf", "-inf")
_LEAST_LIKELIHOOD = 0.6  # predictions below it are left out
_HEADERS = ("scorer", "individuals", "bodyparts", "coords")
_NUMBERS = ("x", "y", "likelihood")


Row: TypeAlias = tuple[str, str, Sequence[str | float]]
"""Place of a row in the file, its picture's path or frame's number, and the columns' cells."""


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
                    raise InputError(f"{coordinate} of {part} is {cell!r}", row[0], remedy)
                found.setdefault((individual, part), {})[coordinate] = number
        for (individual, part), own in found.items():
            x, y = own.get("x", math.nan), own.get("y", math.nan)
            yield individual, part, x, y, own.get("likelihood", 1.0)


def read_table(path: Path, remedy: str) -> DeepLabCutTable:
    """The table of a CSV or HDF5 file; InputError where it cannot be read."""
    if path.suffix.lower() == ".h5":
        check_hdf5(path)
        return read_apart(_stored, path, _REMEDY)
    lines = read_cells(path, headers=3)
    header = {line[0]: line for line in lines[:4] if line and line[0] in _HEADERS}
    if "bodyparts" not in header or "coords" not in header:
        raise InputError("the lines bodyparts and coords are missing", path, remedy)
    coords, parts = header["coords"], header["bodyparts"]
    people = header.get("individuals", [""] * len(coords))
    if not len(people) == len(parts) == len(coords):
        raise InputError("the lines before the numbers are not equally long", path, remedy)
    first = next((k for k, name in enumerate(coords) if name in _NUMBERS), len(coords))
    columns = list(zip(people, parts, coords, strict=True))[first:]
    rows: list[Row] = []
    for number, line in enumerate(lines[len(header) :], start=len(header) + 1):
        if any(line):
            cells = [*line[first:], *[""] * len(columns)][: len(columns)]
            rows.append((f"{path}, line {number}", "/".join(filter(None, line[:first])), cells))
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
        raise InputError(what, path, "Export the labels of one person only.")
    places = label_source.PicturePlaces(source, [picture for _, picture, _ in table.rows])

    def read(row: Row, known: Mapping[str, str]) -> Iterator[Click]:
        if (place := places.of(row[1], row[0])) is None:
            return
        for _, part, x, y, likelihood in table.points(row):
            likely = part in known and likelihood >= _LEAST_LIKELIHOOD
            if likely and math.isfinite(x) and math.isfinite(y):
                yield Click(*place, known[part], (x, y), origin="imported")

    parts = (part for _, part, coordinate in table.columns if coordinate in _NUMBERS)
    return replace(source.labels(parts, table.rows, read), unstated=label_source.PLACES_ALONE)


def predictions_of(source: KeypointSource, table: DeepLabCutTable) -> Iterator[FileRow]:
    """Rows of a table; InputError where a number cannot be read or its camera cannot be told."""
    stem = source.path.stem  # named after its video: ``cam1DLC_resnet50_walk_1.csv``
    named = replace(source, path=source.path.with_name(stem.split("DLC")[0] or stem))
    places = label_source.PicturePlaces(named, [picture for _, picture, _ in table.rows])
    people = list(dict.fromkeys(individual for individual, *_ in table.columns))
    for row in table.rows:
        if (place := places.of(row[1], row[0])) is None:
            continue
        for individual, part, x, y, likelihood in table.points(row):
            who = Who(people.index(individual), individual)
            yield *place, part, x, y, likelihood, source.name, who


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
        raise InputError(what, path, "Export the clicks as csv or coco, or rename the camera.")
    return path.with_name(f"{path.stem}_{camera}{path.suffix}")


def _number(text: str | float) -> float | None:
    try:
        return float(text) if text in _WORDS or isinstance(text, float) else typed_number(text)
    except ValueError:
        return None


_KEY = "df_with_missing"
_WHAT = "this is not a file of DeepLabCut's labels or predictions"
_REMEDY = "Use a .csv or .h5 file written by DeepLabCut; have it write a damaged one again."


StoredTable: TypeAlias = tuple[list[tuple[str, ...]], list[tuple[str, ...]], FloatArray]
"""Of pandas: names (C,) of columns (scorer, individual if there are several, body part, coordinate)
and of rows (R,) (number of the frame, or parts of a picture's path), values (R, C) or NaN."""


def _stored(path: Path) -> DeepLabCutTable:
    """The table of an HDF5 file, in a process of its own."""
    import h5py

    with decoding(path, _WHAT, _REMEDY), h5py.File(path) as stored:
        return table_in(stored, path)


def table_in(stored: Any, path: Path) -> DeepLabCutTable:
    """The table of an open file. ValueError where there is none, or its parts do not fit."""
    groups = [stored[_KEY]] if _KEY in stored else list(stored.values())
    fixed = next((g for g in groups if "block0_values" in g), None)
    table = next((g["table"] for g in groups if "table" in g), None)
    if fixed is None and table is None:
        raise ValueError("it has no table of this kind")
    columns, rows, values = _of_table(table) if fixed is None else _of_fixed(fixed)
    names = [name for name in columns if 3 <= len(name) <= 4]
    if values.shape != (len(rows), len(names)) or len(set(names)) < len(names):
        raise ValueError("its parts do not fit together")
    pictures = ["/".join(named) for named in rows]
    places = (f"{path}, row {picture}" for picture in pictures)
    columns = [(*("",) * (4 - len(name)), *name[1:]) for name in columns]
    return DeepLabCutTable(columns, list(zip(places, pictures, values.tolist(), strict=True)))


def _of_fixed(group: Mapping[str, Any]) -> StoredTable:
    """Of the format ``fixed``, whose columns of other types than the first are further blocks."""
    columns: list[tuple[str, ...]] = []
    blocks: list[FloatArray] = []
    while f"block{len(blocks)}_values" in group:
        columns += _names(group, f"block{len(blocks)}_items")
        blocks.append(_array(group[f"block{len(blocks)}_values"]).astype(np.float64))
    values = np.concatenate(blocks, axis=1)
    there = "axis0" in group or "axis0_level0" in group
    order = {name: k for k, name in enumerate(_names(group, "axis0") if there else columns)}
    places = sorted(range(len(columns)), key=lambda k: order.get(columns[k], k))
    return [columns[k] for k in places], _names(group, "axis1"), values[:, places]


def _of_table(table: Any) -> StoredTable:
    """Of the format ``table``."""
    blocks = [name for name in table.dtype.names or () if name.startswith("values_block_")]
    kinds = (bytes(table.attrs[f"{block}_kind"]) for block in blocks)
    try:
        columns = [name for kind in kinds for name in _Plain(io.BytesIO(kind)).load()]
    except pickle.UnpicklingError as error:
        raise ValueError("its columns have no names") from error
    if not blocks or not all(isinstance(name, tuple) for name in columns):
        raise ValueError("its columns are not named by body part and coordinate")
    index, values = table["index"], [table[block] for block in blocks]
    if index.ndim != 1 or any(one.ndim != 2 or one.dtype.kind not in "iuf" for one in values):
        raise ValueError("its parts do not fit together")
    rows: list[tuple[str, ...]] = [(_text(value),) for value in _array(index).tolist()]
    names = [tuple(map(str, name)) for name in columns]
    return names, rows, np.concatenate(values, axis=1).astype(np.float64)


class _Plain(pickle.Unpickler):
    """Reads lists, tuples, texts and numbers, and nothing that could run."""

    def find_class(self, module: str, name: str) -> NoReturn:
        """Refuse every class and function."""
        raise ValueError(f"it names {module}.{name}")


def _names(group: Mapping[str, Any], axis: str) -> list[tuple[str, ...]]:
    """What an axis is called at each place: one text for each of its levels."""
    if f"{axis}_level0" not in group:
        return [(_text(value),) for value in _array(group[axis]).tolist()]
    columns = []
    for level in range(4):
        if f"{axis}_level{level}" in group:
            texts = [_text(value) for value in _array(group[f"{axis}_level{level}"]).tolist()]
            codes = _array(group[f"{axis}_label{level}"]).tolist()
            if not all(0 <= code < len(texts) for code in codes):
                raise ValueError("its parts do not fit together")
            columns.append([texts[code] for code in codes])
    return list(zip(*columns, strict=True))


def _array(stored: Any) -> Any:
    """Numbers or texts, in the file or read."""
    if stored.dtype.kind not in "iufS":
        raise ValueError("it holds something else than numbers and texts")
    return stored[()]


def _text(value: bytes | float) -> str:
    return value.decode() if isinstance(value, bytes) else str(value)


def check_hdf5(path: Path) -> None:
    """InputError for no regular file, or where h5py is missing; another process will load it."""
    check_file(path)
    missing = "DeepLabCut's HDF5 files need the library h5py, which is not installed"
    check_library("h5py", "sleap", missing=missing, where=str(path), instead="DeepLabCut's .csv")
