"""DeepLabCut's labels and predictions as HDF5, the file that it prefers to the CSV beside it.

A table of pandas with the key ``df_with_missing``, of the format ``fixed`` or ``table``, read by
h5py alone, which runs nothing that a file may hold. The format ``table`` keeps names of columns as
a pickle, of which only texts, numbers, lists and tuples are read; anything else is refused, as it
could run a program.
"""

import io
import pickle
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.interop.hdf5 import read_hdf5
from stereotrack_core.reading import TABLE_BYTES, decoding
from stereotrack_core.versions import check_library

KEY = "df_with_missing"
_WHAT = "this is not a file of DeepLabCut's labels or predictions"
_REMEDY = "Use a .csv or .h5 file written by DeepLabCut; have it write a damaged one again."
_INSTEAD = "DeepLabCut's .csv"


@dataclass(frozen=True, eq=False)
class StoredTable:
    """A table of pandas."""

    columns: Sequence[tuple[str, ...]]
    """(C,). Scorer, individual if there are several, body part and coordinate."""
    rows: Sequence[tuple[str, ...]]  # (R,). Number of the frame, or the parts of a picture's path.
    values: FloatArray  # (R, C). NaN where there is none.


def stored_table(path: Path) -> StoredTable:
    """Read the table. InputError where the file cannot be read, or h5py is not installed."""
    check_h5py(path)
    return read_hdf5(path, _stored, _WHAT, _REMEDY)


def _stored(path: Path) -> StoredTable:
    import h5py

    with decoding(path, _WHAT, _REMEDY), h5py.File(path) as stored:
        return table_in(stored)


def table_in(stored: Any) -> StoredTable:
    """The table of an open file. ValueError where there is none, or its parts do not fit."""
    groups = [stored[KEY]] if KEY in stored else list(stored.values())
    fixed = next((g for g in groups if "block0_values" in g), None)
    table = next((g["table"] for g in groups if "table" in g), None)
    if fixed is not None:
        found = _of_fixed(fixed)
    elif table is not None:
        found = _of_table(table)
    else:
        raise ValueError("it has no table of this kind")
    names = [name for name in found.columns if 3 <= len(name) <= 4]
    if found.values.shape != (len(found.rows), len(names)) or len(set(names)) < len(names):
        raise ValueError("its parts do not fit together")
    return found


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
    return StoredTable([columns[k] for k in places], _names(group, "axis1"), values[:, places])


def _of_table(table: Any) -> StoredTable:
    """Of the format ``table``."""
    if table.size * table.dtype.itemsize > TABLE_BYTES:
        raise ValueError("it is too large")
    blocks = [name for name in table.dtype.names or () if name.startswith("values_block_")]
    columns = [name for block in blocks for name in _plain(bytes(table.attrs[f"{block}_kind"]))]
    if not blocks or not all(isinstance(name, tuple) for name in columns):
        raise ValueError("its columns are not named by body part and coordinate")
    index, values = table["index"], [table[block] for block in blocks]
    if index.ndim != 1 or any(one.ndim != 2 or one.dtype.kind not in "iuf" for one in values):
        raise ValueError("its parts do not fit together")
    rows = [(_text(value),) for value in _array(index).tolist()]
    names = [tuple(map(str, name)) for name in columns]
    return StoredTable(names, rows, np.concatenate(values, axis=1).astype(np.float64))


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
    """Numbers or texts, in the file or read, that are not too large."""
    if stored.dtype.kind not in "iufS" or stored.size * stored.dtype.itemsize > TABLE_BYTES:
        raise ValueError("it holds something else than numbers and texts")
    return stored[()]


def _text(value: bytes | float) -> str:
    return value.decode() if isinstance(value, bytes) else str(value)


def check_h5py(path: Path) -> None:
    """InputError where h5py is not installed; another process will load it."""
    missing = "DeepLabCut's HDF5 files need the library h5py, which is not installed"
    check_library("h5py", "sleap", missing=missing, where=str(path), instead=_INSTEAD)
