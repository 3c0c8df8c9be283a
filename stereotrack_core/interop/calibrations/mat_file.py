"""MAT files of version 5 to 7 as plain data: numbers, texts, cells and structs.

Read here because the usual reader ends the program on some damaged files. The layout is that of
"MAT-File Format" (The MathWorks), level 5. What is no plain data, such as objects of classes, is
None.
"""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Iterator
from typing import Any

import numpy as np

from stereotrack_core.reading import MB

_NUMBERS = {
    1: "i1",
    2: "u1",
    3: "i2",
    4: "u2",
    5: "i4",
    6: "u4",
    7: "f4",
    9: "f8",
    12: "i8",
    13: "u8",
}
_MATRIX, _COMPRESSED = 14, 15
_TEXTS = {1: "latin-1", 2: "latin-1", 4: "utf-16", 16: "utf-8", 17: "utf-16", 18: "utf-32"}
_CELL, _STRUCT, _CHAR = 1, 2, 4
_NUMERIC = range(6, 16)  # classes of arrays

_HEADER = 128
_MOST_BYTES = 64 * MB  # of a variable that was compressed
_MOST_NUMBERS = 10_000  # larger arrays hold pictures or points, no calibration
_MOST_ELEMENTS = 20_000  # of cells and structs, all together
_DEEPEST = 12


def variables_of(data: bytes) -> dict[str, Any]:
    """Variables of a file by name; arrays are lists, rows first, vectors flat, 1 x 1 a number.

    Raises ValueError, EOFError, struct.error, zlib.error or RecursionError where it is damaged.
    """
    order = {b"IM": "<", b"MI": ">"}.get(data[126:128])
    if order is None:
        raise ValueError("this is no MAT file of level 5")
    reader = _Reader(order)
    found: dict[str, Any] = {}
    for kind, content in reader.elements(data[_HEADER:]):
        if kind == _COMPRESSED:
            unpacked = zlib.decompressobj().decompress(content, _MOST_BYTES)
            inner = list(reader.elements(unpacked))
        else:
            inner = [(kind, content)]
        for one, array in inner:
            if one == _MATRIX and array:
                name, value = reader.array(array)
                found[name] = value
    return found


class _Reader:
    """Reads elements of one byte order, and counts what it has made of them."""

    def __init__(self, order: str) -> None:
        self._order = order
        self._made = 0

    def elements(self, data: bytes) -> Iterator[tuple[int, bytes]]:
        """Type and content of the elements that stand one after the other."""
        at = 0
        while at + 8 <= len(data):
            kind, size = struct.unpack_from(f"{self._order}II", data, at)
            start, step = at + 8, 8
            if kind >> 16:  # a small one: its size is in the type, its content behind that
                kind, size, start, step = kind & 0xFFFF, kind >> 16, at + 4, 4
                if size > 4:
                    raise ValueError("a small element is too large")
            if start + size > len(data):
                raise EOFError
            yield kind, data[start : start + size]
            padded = size if kind == _COMPRESSED else -(-size // 8) * 8
            at = start + (4 if step == 4 else padded)

    def array(self, data: bytes, depth: int = 0) -> tuple[str, Any]:
        """Name and value of an array."""
        self._made += 1
        if depth > _DEEPEST or self._made > _MOST_ELEMENTS:
            raise RecursionError
        parts = self.elements(data)
        flags = self._numbers(*_next(parts))
        shape = tuple(int(length) for length in self._numbers(*_next(parts)))
        name = _next(parts)[1].decode("latin-1")
        kind = int(flags[0]) & 0xFF
        if not shape or min(shape) < 0:
            raise ValueError("an array has no shape")
        count = math.prod(shape)
        if kind == _CHAR:
            return name, self._text(*next(parts, (1, b"")))
        if kind == _CELL and count <= _MOST_ELEMENTS:
            return name, [self._inner(next(parts, None), depth) for _ in range(count)]
        if kind == _STRUCT and count <= _MOST_ELEMENTS:
            return name, self._structs(parts, count, depth)
        if kind in _NUMERIC and count <= _MOST_NUMBERS:
            return name, _plain(self._numbers(*next(parts, (9, b""))), shape)
        return name, None

    def _inner(self, element: tuple[int, bytes] | None, depth: int) -> Any:
        if element is None:
            raise EOFError
        kind, content = element
        return self.array(content, depth + 1)[1] if kind == _MATRIX and content else None

    def _structs(self, parts: Iterator[tuple[int, bytes]], count: int, depth: int) -> Any:
        length = int(self._numbers(*_next(parts))[0])
        names = _next(parts)[1]
        if length < 1:
            raise ValueError("a struct has no names")
        fields = [
            names[at : at + length].split(b"\0")[0].decode("latin-1")
            for at in range(0, len(names), length)
        ]
        made = [
            {field: self._inner(next(parts, None), depth) for field in fields}
            for _ in range(count if fields else 0)
        ]
        return made[0] if len(made) == 1 else made

    def _numbers(self, kind: int, content: bytes) -> np.ndarray[Any, np.dtype[Any]]:
        if kind not in _NUMBERS:
            raise ValueError("an array holds no numbers")
        return np.frombuffer(content, np.dtype(f"{self._order}{_NUMBERS[kind]}"))

    def _text(self, kind: int, content: bytes) -> str:
        encoding = _TEXTS.get(kind)
        if encoding is None:
            raise ValueError("a text holds no letters")
        if encoding in ("utf-16", "utf-32"):
            encoding += "-le" if self._order == "<" else "-be"
        return content.decode(encoding)


def _next(parts: Iterator[tuple[int, bytes]]) -> tuple[int, bytes]:
    found = next(parts, None)
    if found is None:
        raise EOFError
    return found


def _plain(numbers: np.ndarray[Any, np.dtype[Any]], shape: tuple[int, ...]) -> Any:
    """An array whose numbers stand column after column."""
    array = numbers.astype(np.float64).reshape(shape, order="F")
    if array.size == 1:
        return float(array.ravel()[0])
    return array.ravel().tolist() if array.size == max(shape) else array.tolist()
