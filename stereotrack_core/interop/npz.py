"""Archives of arrays whose layout is known: no value is read before its header fits."""

import io
import math
import os
import warnings
import zipfile
from collections.abc import Collection, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from stereotrack_core.arrays import FloatArray
from stereotrack_core.errors import InputError
from stereotrack_core.reading import MB, TABLE_BYTES, decoding, read_bytes

_LARGEST_TOTAL = 256 * MB
_LARGEST_RATIO = 32  # bytes of arrays for each byte of a file, unless they are few altogether
_FLOATS = (4, 8)  # bytes of the numbers that all of NumPy computes with
_HEADERS = {
    (1, 0): np.lib.format.read_array_header_1_0,
    (2, 0): np.lib.format.read_array_header_2_0,
}


def read_number_array(path: Path, remedy: str) -> FloatArray:
    """Numbers of a .npy file of any shape, read before its header is believed; else InputError."""
    content = read_bytes(path, TABLE_BYTES)
    what = "this is no NumPy array of numbers"
    with decoding(path, what, remedy):
        with warnings.catch_warnings(action="ignore", category=UserWarning):  # Python 2 wrote it
            array = np.lib.format.read_array(io.BytesIO(content), allow_pickle=False)
        if array.dtype.kind not in "fiub":
            raise InputError(f"{what} ({array.dtype})", path, remedy)
        return array.astype(np.float64)


@dataclass(frozen=True)
class ArrayLayout:
    """What an array of an archive shall be."""

    kind: str  # of NumPy's type: ``f``, ``i``, ``b`` or ``U``
    shape: tuple[int | str, ...]  # a letter or word stands for the same length wherever it appears
    optional: bool = False  # whether it may be missing


@dataclass(frozen=True)
class ArchiveFormat:
    """Archives of one kind."""

    what: str  # what such a file is called, such as ``run file of this program``
    remedy: str  # what to do about a file that is none
    layout: Mapping[str, ArrayLayout]

    def read(
        self, file: BinaryIO, where: str, names: Collection[str] | None = None
    ) -> dict[str, NDArray[Any]]:
        """Arrays of the layout, or those with some `names`; InputError if damaged, or others."""
        with self.decoding(where):
            size = file.seek(0, os.SEEK_END)
            with zipfile.ZipFile(file) as archive:
                stored = {one.filename.removesuffix(".npy"): one for one in archive.infolist()}
                needed = [name for name, own in self.layout.items() if not own.optional]
                if missing := [name for name in needed if name not in stored]:
                    raise self.refusal(where, f"it lacks {', '.join(missing)}")
                asked = self.layout if names is None else names
                there = {name: self.layout[name] for name in asked if name in stored}
                lengths: dict[str, int] = {}
                total = 0
                for name, own in there.items():
                    shape, dtype = _header(archive, stored[name])
                    if wrong := _mismatch(name, shape, dtype, own, lengths):
                        raise self.refusal(where, wrong)
                    total += math.prod(shape) * dtype.itemsize
                if total > max(_LARGEST_TOTAL, _LARGEST_RATIO * size):
                    raise self.refusal(where, f"it claims to contain {total // MB} MB")
                return {name: _values(archive, name) for name in there}

    def decoding(self, where: Path | str) -> AbstractContextManager[None]:
        """Say of what a decoder raises that the file is none of these."""
        return decoding(where, f"the file is damaged or is not a {self.what}", self.remedy)

    def refusal(self, where: str, reason: str) -> InputError:
        """The complaint about a file that is none of these."""
        return InputError(f"this is not a {self.what}: {reason}", where, self.remedy)


def archive_bytes(arrays: Mapping[str, Any], *, compressed: bool = True) -> bytes:
    """Content of an archive with these arrays, none of which may hold objects."""
    if objects := [name for name, array in arrays.items() if np.asarray(array).dtype.hasobject]:
        raise TypeError(f"arrays of objects would be pickled: {', '.join(objects)}")
    file = io.BytesIO()
    if compressed:  # without `allow_pickle`, which numpy 2.0 takes for one more array
        np.savez_compressed(file, **arrays)
    else:
        np.savez(file, **arrays)
    return file.getvalue()


def array_names(file: BinaryIO) -> frozenset[str]:
    """Names of the arrays in an archive; InputError where it is none."""
    wrong = decoding("", "this is not an archive of arrays", "Use another copy of the file.")
    with wrong, zipfile.ZipFile(file) as archive:
        return frozenset(name.removesuffix(".npy") for name in archive.namelist())


def _header(
    archive: zipfile.ZipFile, info: zipfile.ZipInfo
) -> tuple[tuple[int, ...], np.dtype[Any]]:
    """Shape and type of a member; ValueError where its header contradicts the archive."""
    if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise ValueError(info.filename)  # others unfold into far more than NumPy writes
    with archive.open(info) as file:
        shape, _, dtype = _HEADERS[np.lib.format.read_magic(file)](file)
        if file.tell() + math.prod(shape) * dtype.itemsize != info.file_size:
            raise ValueError(info.filename)
    return shape, dtype


def _mismatch(
    name: str, shape: tuple[int, ...], dtype: np.dtype[Any], own: ArrayLayout, known: dict[str, int]
) -> str:
    """Complaint about an array as a sentence, else empty; adds its lengths to `known`."""
    if dtype.kind != own.kind or (own.kind == "f" and dtype.itemsize not in _FLOATS):
        return f"{name} has the wrong data type ({dtype})"
    if len(shape) != len(own.shape):
        return f"{name} has {len(shape)} dimensions, expected {len(own.shape)}"
    for length, wanted in zip(shape, own.shape, strict=True):
        right = known.setdefault(wanted, length) if isinstance(wanted, str) else wanted
        if length != right or length < 0:
            return f"{name} has the length {length}, expected {right}"
    return ""


def _values(archive: zipfile.ZipFile, name: str) -> NDArray[Any]:
    """Values of an array whose header was found right."""
    with archive.open(f"{name}.npy") as file:
        values: NDArray[Any] = np.lib.format.read_array(file, allow_pickle=False)
    if values.dtype.kind == "U":  # NumPy does not ask whether they can be taken for Python's
        codes = values.ravel().view(np.dtype(np.uint32).newbyteorder(values.dtype.byteorder))
        if (codes >= 0x110000).any():
            raise ValueError(name)
    return values
