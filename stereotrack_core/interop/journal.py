"""A journal: one JSON object per line, only ever appended to.

A line counts once it is complete. Whoever is killed while writing one loses that line alone; the
next one to write begins a new line after what is left of it.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any

from stereotrack_core.errors import InputError
from stereotrack_core.reading import TABLE_BYTES, parsed_json, read_bytes


def read_journal(path: Path) -> list[dict[str, Any]]:
    """All complete entries, the oldest first; none where there is no file.

    InputError where the file cannot be read.
    """
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


class Journal:
    """A journal that is written to; every entry is on the disk when :meth:`append` returns.

    Raises InputError where nothing can be written there.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        try:
            self._file: IO[bytes] = path.open("ab")
            self._torn = _is_torn(path)
        except OSError as error:
            raise self._refusal(error) from None

    def __enter__(self) -> Journal:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def append(self, entry: Mapping[str, Any]) -> None:
        """Write one entry; InputError where the disk is full or gone."""
        line = json.dumps(entry, ensure_ascii=False, allow_nan=False).encode() + b"\n"
        try:
            self._file.write(b"\n" + line if self._torn else line)
            self._file.flush()
            os.fsync(self._file.fileno())
        except OSError as error:
            self._torn = True
            raise self._refusal(error) from None
        self._torn = False

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def _refusal(self, error: OSError) -> InputError:
        return InputError(
            f"the journal cannot be written ({error.strerror})",
            where=str(self._path),
            remedy="Free space or choose another place. The data written so far remain valid.",
        )


def _is_torn(path: Path) -> bool:
    """Whether the last line has no end."""
    with path.open("rb") as file:
        if not file.seek(0, os.SEEK_END):
            return False
        file.seek(-1, os.SEEK_END)
        return file.read(1) != b"\n"
