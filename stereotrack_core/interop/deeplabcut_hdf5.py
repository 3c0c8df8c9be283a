"""DeepLabCut's labels as HDF5, the file that it goes by where there is a CSV of the same name.

A table of pandas of the format ``fixed`` with the key ``df_with_missing``: written by the optional
libraries pandas and PyTables, read by h5py alone, which runs nothing that a file may hold.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.errors import InputError
from stereotrack_core.interop.hdf5 import read_hdf5
from stereotrack_core.reading import TABLE_BYTES, decoding
from stereotrack_core.versions import check_library, extra_library

KEY = "df_with_missing"
_WHAT = "this is not a file of DeepLabCut's labels"
_REMEDY = (
    "Use a .csv or .h5 file of labels (CollectedData) written by DeepLabCut; "
    "have it write a damaged one again."
)
_INSTEAD = "DeepLabCut's .csv"


def hdf5_of(
    path: Path,
    rows: Sequence[tuple[str, ...]],
    parts: Sequence[str],
    values: FloatArray,
    scorer: str,
) -> bytes:
    """The file of labels (F, 2 N), pixels, NaN where there is none.

    Each row of them is named by the folders and the name of its picture, each pair of columns by
    one of the N `parts`. `path` is where it will be.

    InputError where there are no labels, or a library is not installed.
    """
    pandas = _library("pandas", path)
    _library("tables", path)
    columns = pandas.MultiIndex.from_product(
        [[scorer], list(parts), ["x", "y"]], names=["scorer", "bodyparts", "coords"]
    )
    if not rows:
        raise InputError(
            "there are no clicks to write",
            where=str(path),
            remedy="Click landmarks first, or use .csv, which may be empty.",
        )
    frame = pandas.DataFrame(values, index=pandas.MultiIndex.from_tuples(rows), columns=columns)
    memory = {"driver": "H5FD_CORE", "driver_core_backing_store": 0}
    with pandas.HDFStore("labels.h5", mode="w", **memory) as store:
        store.put(KEY, frame, track_times=False)
        store.flush()
        data: bytes = store._handle.get_file_image()
    return data


def cells_of(path: Path) -> list[list[str]]:
    """The same table as the cells of DeepLabCut's CSV, with a column for each part of a path.

    InputError where the file cannot be read, or h5py is not installed.
    """
    _check_h5py(path)
    names, pictures, values = read_hdf5(path, _stored, _WHAT, _REMEDY)
    numbers = values.tolist()
    width = max((len(picture) for picture in pictures), default=1)
    headers = ("scorer", "individuals", "bodyparts", "coords")
    kept = headers if len(names[0]) > 3 else (headers[0], *headers[2:])
    lines = [
        [header, *[""] * (width - 1), *(name[k] for name in names)] for k, header in enumerate(kept)
    ]
    for picture, row in zip(pictures, numbers, strict=True):
        cells = [repr(value) if math.isfinite(value) else "" for value in row]
        lines.append([*picture, *[""] * (width - len(picture)), *cells])
    return lines


def _stored(path: Path) -> tuple[list[tuple[str, ...]], list[tuple[str, ...]], FloatArray]:
    """Names of columns, those of rows, and the numbers."""
    import h5py

    with decoding(path, _WHAT, _REMEDY), h5py.File(path) as f:
        group = f[KEY] if KEY in f else next((g for g in f.values() if "block0_values" in g), f)
        names, pictures = _names(group, "block0_items"), _names(group, "axis1")
        values = _array(group["block0_values"])
        if values.shape != (len(pictures), len(names)) or not all(
            len(name) >= 3 for name in names or [()]
        ):
            raise ValueError("its parts do not fit together")
        return names, pictures, values.astype(np.float64)


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
    """A data set of numbers or texts that is not too large."""
    if stored.dtype.kind not in "iufS" or stored.size * stored.dtype.itemsize > TABLE_BYTES:
        raise ValueError("it holds something else than numbers and texts")
    return stored[()]


def _text(value: bytes | float) -> str:
    return value.decode() if isinstance(value, bytes) else str(value)


def _check_h5py(path: Path) -> None:
    missing, where = _missing("h5py"), str(path)
    check_library("h5py", "sleap", missing=missing, where=where, instead=_INSTEAD)


def _library(name: str, path: Path) -> Any:
    missing, where, instead = _missing(name), str(path), _INSTEAD
    if name == "tables":
        return extra_library("tables", "deeplabcut", missing=missing, where=where, instead=instead)
    return extra_library("pandas", "deeplabcut", missing=missing, where=where, instead=instead)


def _missing(name: str) -> str:
    return f"DeepLabCut's HDF5 files need the library {name}, which is not installed"
