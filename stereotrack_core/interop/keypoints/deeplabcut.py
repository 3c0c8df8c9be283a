"""DeepLabCut's predictions: CSV or HDF5, one file for each video; several individuals are people.

The HDF5 file is a table of pandas whose column names are kept as a pickle. Only texts, numbers,
lists and tuples are read of it; anything else is refused, as it could run a program.
"""

from __future__ import annotations

import io
import pickle
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.errors import InputError
from stereotrack_core.interop.deeplabcut import place_of_row
from stereotrack_core.interop.hdf5 import read_hdf5
from stereotrack_core.interop.keypoints.source import KeypointSource
from stereotrack_core.interop.label_source import LabelSource
from stereotrack_core.reading import TABLE_BYTES, decoding
from stereotrack_core.recording.keypoints import Row
from stereotrack_core.tables import finite_number, read_cells
from stereotrack_core.versions import check_library

_HEADERS = ("scorer", "individuals", "bodyparts", "coords")
_WHAT = "this is not a DeepLabCut file"
_REMEDY = (
    "Use a .csv or .h5 file written by DeepLabCut's analyze_videos; have it write a damaged one "
    "again."
)
_NUMBERS = ("x", "y", "likelihood")


def read_csv(source: KeypointSource) -> Iterator[Row]:
    """Rows of a CSV file; InputError where it cannot be read or its camera cannot be told."""
    path, lines = source.path, read_cells(source.path)
    header = {line[0]: line for line in lines[:4] if line and line[0] in _HEADERS}
    if "bodyparts" not in header or "coords" not in header:
        raise InputError("it lacks bodyparts or coords", where=str(path), remedy=_REMEDY)
    coords = header["coords"]
    first = next((k for k, name in enumerate(coords) if name in _NUMBERS), len(coords))
    people, parts = header.get("individuals", [""] * len(coords)), header["bodyparts"]
    if not len(people) == len(parts) == len(coords):
        raise InputError(
            "the lines before the numbers are not equally long", where=str(path), remedy=_REMEDY
        )
    columns = list(zip(people, parts, coords, strict=True))[first:]
    for number, line in enumerate(lines[len(header) :], start=len(header) + 1):
        if any(line):
            place = place_of_row(line[:first], _video(source), f"{path}, line {number}")
            cells = [*line[first:], *[""] * len(columns)][: len(columns)]
            values = [
                finite_number(cell, path, number, column[1])
                if cell and cell.lower() != "nan"
                else float("nan")
                for cell, column in zip(cells, columns, strict=True)
            ]
            yield from _rows(values, columns, source, place)


def read_h5(source: KeypointSource) -> Iterator[Row]:
    """Rows of an HDF5 file; InputError where it cannot be read or h5py is not installed."""
    path = source.path
    missing = "HDF5 files need the library h5py, which is not installed"
    instead, where = "DeepLabCut's .csv", str(path)
    check_library("h5py", "sleap", missing=missing, where=where, instead=instead)
    camera = source.camera_of(_video(source).path.name, where)
    columns, frames, every = read_hdf5(path, _stored, _WHAT, _REMEDY)
    for frame, values in zip(frames.tolist(), every.tolist(), strict=True):
        yield from _rows(values, columns, source, (frame, camera))


def _stored(path: Path) -> tuple[list[tuple[str, ...]], IntArray, FloatArray]:
    import h5py

    with decoding(path, _WHAT, _REMEDY), h5py.File(path) as stored:
        return _table_of(stored)


def _table_of(stored: Any) -> tuple[list[tuple[str, ...]], IntArray, FloatArray]:
    """Columns of individual, body part and coordinate, frames, and a row of numbers for each.

    ValueError where the file has something else.
    """
    table = next((one["table"] for one in stored.values() if "table" in one), None)
    if table is None or table.size * table.dtype.itemsize > TABLE_BYTES:
        raise ValueError("it has no table of this kind")
    blocks = [name for name in table.dtype.names or () if name.startswith("values_block_")]
    names = _plain(bytes(table.attrs["values_block_0_kind"]))
    frames, every = table["index"], table["values_block_0"]
    fits = every.shape == (len(frames), len(names)) and blocks == ["values_block_0"]
    if (
        not fits
        or frames.ndim != 1
        or frames.dtype.kind not in "iu"
        or every.dtype.kind not in "iuf"
    ):
        raise ValueError("its parts do not fit together")
    if not all(isinstance(name, tuple) and 3 <= len(name) <= 4 for name in names):
        raise ValueError("its columns are not named by body part and coordinate")
    columns = [(*("",) * (4 - len(name)), *map(str, name[1:])) for name in names]
    if len(set(columns)) < len(columns):
        raise ValueError("two columns have the same name")
    return columns, frames, every.astype(np.float64)


def _video(source: KeypointSource) -> LabelSource:
    """The source, named after its video: ``cam1`` for ``cam1DLC_resnet50_walk_1.csv``."""
    path = source.path
    return replace(source.labels, path=path.with_name(path.stem.split("DLC")[0] or path.stem))


def _rows(
    values: Sequence[float],
    columns: Iterable[tuple[str, ...]],
    source: KeypointSource,
    place: tuple[int, str],
) -> Iterator[Row]:
    """Rows of one frame, from the numbers of columns of individual, body part and coordinate."""
    found: dict[tuple[str, str], dict[str, float]] = {}
    for value, (individual, part, coordinate) in zip(values, columns, strict=True):
        found.setdefault((individual, part), {})[coordinate] = value
    people = list(dict.fromkeys(individual for individual, _ in found))
    nothing = float("nan")
    for (individual, part), own in found.items():
        x, y = own.get("x", nothing), own.get("y", nothing)
        person = people.index(individual)
        yield *place, part, x, y, own.get("likelihood", 1.0), source.name, person


class _Plain(pickle.Unpickler):
    """Reads lists, tuples, texts and numbers, and nothing that could run."""

    def find_class(self, module: str, name: str) -> NoReturn:
        """Refuse every class and function."""
        raise ValueError(f"it names {module}.{name}")


def _plain(content: bytes) -> Any:
    try:
        return _Plain(io.BytesIO(content)).load()
    except pickle.UnpicklingError as error:
        raise ValueError("its columns have no names") from error
