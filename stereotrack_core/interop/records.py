"""Files that are only ever appended to: of JSON lines, and of records of facts and arrays.

A line counts once it is complete, a record by its length and a checksum. Whoever is killed while
writing one loses that one alone. Nothing in them is ever executed; a stranger's file can be read as
safely as any other.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import struct
import time
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from stereotrack_core.errors import InputError
from stereotrack_core.locks import take_lock
from stereotrack_core.reading import MB, TABLE_BYTES, open_file, parsed_json, read_bytes


def read_journal(path: Path) -> list[dict[str, Any]]:
    """All complete entries, the oldest first, none without a file; InputError if unreadable."""
    if not path.exists():
        return []
    lines = read_bytes(path, TABLE_BYTES).split(b"\n")
    entries = []
    for line in lines[:-1]:  # what stands after the last line's end was not finished
        try:
            entry = parsed_json(line, str(path))
        except InputError:
            continue  # a line that somebody was killed in
        if isinstance(entry, dict):
            entries.append(entry)
    return entries


def append_entry(path: Path, entry: Mapping[str, Any]) -> None:
    """Write one entry, which is on the disk then; InputError where the disk is full or gone."""
    line = json.dumps(entry, ensure_ascii=False, allow_nan=False).encode() + b"\n"
    try:
        with path.open("a+b") as file:
            if size := file.seek(0, os.SEEK_END):
                file.seek(size - 1)
            torn = file.read(1) not in (b"\n", b"")  # the last line has no end
            file.write(b"\n" + line if torn else line)
            file.flush()
            os.fsync(file.fileno())
    except OSError as error:
        what = f"the journal cannot be written ({error.strerror})"
        remedy = "Free space or choose another place. The data written so far remain valid."
        raise InputError(what, path, remedy) from None


_FRAME = struct.Struct("<4sII")  # kind of record, length and checksum of what follows
_MOST_BYTES = 16384 * MB

_TYPES = ("<f8", "<i8", "|u1", "|b1")

_NO_RECORD = (ValueError, TypeError, OverflowError, RecursionError, struct.error)
"""What reading something else raises whose checksum is right nevertheless."""

_SECONDS_AT_RISK = 1.0  # that a power failure may take; being killed loses nothing written


@dataclass(frozen=True, eq=False)
class Record:
    """Facts (JSON) and arrays under a kind of four letters."""

    kind: str
    facts: Mapping[str, Any]
    arrays: Mapping[str, NDArray[Any]] = field(default_factory=dict)


class RecordFile:
    """A file that records are appended to; no other program may write to it meanwhile.

    `magic`: the eight bytes that such files begin with.

    Raises BlockingIOError where another program writes to it; OSError where it cannot be written
    to; ValueError where something else is in the file.
    """

    def __init__(self, path: Path, magic: bytes) -> None:
        self.path, self._synced = path, time.monotonic()
        path.touch()
        self._file: IO[bytes] = path.open("r+b", buffering=0)
        try:
            take_lock(self._file)
            self._end = len(magic)
            for _ in _payloads(self._file, magic):
                self._end = self._file.tell()
            if os.fstat(self._file.fileno()).st_size < self._end:
                self._end = 0
            self._file.truncate(self._end)
            self._file.seek(self._end)
            if not self._end:
                self._write(magic)
        except BaseException:
            self._file.close()
            raise

    def append(self, record: Record) -> None:
        """Write a record that can be read from now on; OSError where the drive is full or gone."""
        payload = _packed(record)
        kind = record.kind.encode("ascii")
        checksum = zlib.crc32(payload, zlib.crc32(kind))
        self._write(_FRAME.pack(kind, len(payload), checksum) + payload)

    def close(self) -> None:
        """Let go of the file; a second time does nothing."""
        self._file.close()

    def _write(self, data: bytes) -> None:
        try:
            rest = memoryview(data)
            while rest:
                rest = rest[self._file.write(rest) :]
            if time.monotonic() - self._synced > _SECONDS_AT_RISK:
                os.fsync(self._file.fileno())
                self._synced = time.monotonic()
        except OSError as error:
            with contextlib.suppress(OSError):
                self._file.truncate(self._end)
                self._file.seek(self._end)
            raise OSError(error.errno, error.strerror, str(self.path)) from None
        self._end += len(data)


def read_records(path: Path, magic: bytes) -> Iterator[Record]:
    """Complete records, the oldest first, whose checksum is right; ValueError if foreign."""
    with open_file(path, _MOST_BYTES) as file:
        for kind, payload in _payloads(file, magic):
            try:
                record = _unpacked(kind, payload)
            except _NO_RECORD:
                continue
            yield record


def _payloads(file: IO[bytes], magic: bytes) -> Iterator[tuple[bytes, bytes]]:
    size = os.fstat(file.fileno()).st_size
    if not magic.startswith(file.read(len(magic))):
        raise ValueError("unknown file signature")
    while len(head := file.read(_FRAME.size)) == _FRAME.size:
        kind, length, checksum = _FRAME.unpack(head)
        if length > size - file.tell():
            return
        payload = file.read(length)
        if zlib.crc32(payload, zlib.crc32(kind)) == checksum:
            yield kind, payload


def _packed(record: Record) -> bytes:
    layout, parts = [], []
    for name, given in record.arrays.items():
        array = np.asarray(given)
        plain = array.astype(array.dtype.newbyteorder("<"), copy=False)
        turned = plain.flags.f_contiguous and not plain.flags.c_contiguous
        layout.append([name, plain.dtype.str, plain.shape, "F" if turned else "C"])
        parts.append(plain.tobytes(order="F" if turned else "C"))
    head = json.dumps([record.facts, layout], ensure_ascii=False).encode()
    return b"".join([struct.pack("<I", len(head)), head, *parts])


def _unpacked(kind: bytes, payload: bytes) -> Record:
    (length,) = struct.unpack_from("<I", payload)
    facts, layout = json.loads(payload[4 : 4 + length])
    if not isinstance(facts, dict):
        raise ValueError("missing data")
    arrays, at = {}, 4 + length
    for name, dtype, shape, order in layout:
        lengths = all(isinstance(length, int) and length >= 0 for length in shape)
        if dtype not in _TYPES or order not in ("C", "F") or not lengths:
            raise ValueError("an array has an unsupported type")
        flat = np.frombuffer(payload, dtype, math.prod(shape), at)
        at += flat.nbytes
        # in the order that it had in memory, on which the last bit of later sums may depend
        arrays[str(name)] = flat.reshape(shape, order=order).copy(order="K")
    return Record(kind.decode("ascii", "replace"), facts, arrays)
