"""What was read of a study's files, kept beside it, so that nothing unchanged is read twice."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError
from stereotrack_core.plain_data import Kind, check_kind
from stereotrack_core.reading import MB, read_json
from stereotrack_core.version import __version__

_MOST_BYTES = 256 * MB
_FORMAT = 1

T = TypeVar("T")

Stamp: TypeAlias = list[int] | None
"""Size and time of the last change, nanoseconds; None where there is no such file."""

_KIND: Kind = {
    "format": int,
    "version": str,
    "entries": {str: {"sources": {str: (int, [int])}, "also": str, "facts": {str: object}}},
}


@dataclass(frozen=True)
class Read:
    """Something that was read, and the files that it depends on, whether they exist or not."""

    facts: Mapping[str, Any]
    sources: tuple[Path, ...]


class StudyCache:
    """Facts by name, each valid while the files that it was read from are the same.

    The file may be deleted at any time. One that is damaged, or of another version of this program,
    counts as empty.

    Attributes
    ----------
    reads : int
        How often something had to be read since the cache was opened.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.reads = 0
        self._entries: dict[str, dict[str, Any]] = {}
        self._used: set[str] = set()
        self._changed = False
        self._stamps: dict[str, Stamp] = {}
        try:
            content = read_json(path, _MOST_BYTES)
            check_kind(content, _KIND, str(path), "Delete it.")
        except InputError:
            return
        if content.get("format") == _FORMAT and content.get("version") == __version__:
            entries = (content.get("entries") or {}).items()
            self._entries = {name: one for name, one in entries if _is_whole(one)}

    def known(self, name: str, made: Callable[[Mapping[str, Any]], T]) -> T | None:
        """What was read last, which may no longer be right; None where nothing was.

        `made` makes it of plain data.
        """
        entry = self._entries.get(name)
        return None if entry is None else _attempted(made, entry["facts"])

    def facts(
        self,
        name: str,
        read: Callable[[], Read],
        made: Callable[[Mapping[str, Any]], T],
        also: str = "",
    ) -> T:
        """What is known under that name where its files are unchanged, else what is read now.

        `made` makes it of plain data; `also` is what it depends on besides files.
        """
        self._used.add(name)
        entry = self._entries.get(name)
        if entry is not None and entry["also"] == also and self._is_valid(entry["sources"]):
            known = _attempted(made, entry["facts"])
            if known is not None:
                return known
        begun = time.time_ns()
        self.reads += 1
        found = read()
        sources = {
            self._relative(path): self._stamp(self._relative(path)) for path in found.sources
        }
        if all(stamp is None or stamp[1] < begun for stamp in sources.values()):
            self._entries[name] = {"sources": sources, "also": also, "facts": dict(found.facts)}
        else:  # a file has changed while it was read
            self._entries.pop(name, None)
        self._changed = True
        return made(found.facts)

    def save(self, *, forget: bool = False) -> None:
        """Write what is known, where it has changed.

        `forget`: whether to leave out what was not asked for since the cache was opened. Raises
        InputError where it cannot be written.
        """
        if forget and self._entries.keys() - self._used:
            self._entries = {k: one for k, one in self._entries.items() if k in self._used}
            self._changed = True
        if not self._changed:
            return
        content = {"format": _FORMAT, "version": __version__, "entries": self._entries}
        write_file(self.path, json.dumps(content, allow_nan=False, separators=(",", ":")))
        self._changed = False

    def _is_valid(self, sources: Mapping[str, Stamp]) -> bool:
        return all(self._stamp(path) == stamp for path, stamp in sources.items())

    def _stamp(self, relative: str) -> Stamp:
        """Of a file as it was found first since the cache was opened."""
        if relative not in self._stamps:
            self._stamps[relative] = stamp_of(self.path.parent / relative)
        return self._stamps[relative]

    def _relative(self, path: Path) -> str:
        try:
            return os.path.relpath(path, self.path.parent)
        except ValueError:  # another drive of Windows
            return str(path)


def _is_whole(entry: Mapping[str, Any] | None) -> bool:
    """Whether an entry of a file lacks nothing."""
    found = entry or {}
    return all(found.get(key) is not None for key in ("sources", "also", "facts"))


def _attempted(made: Callable[[Mapping[str, Any]], T], facts: Mapping[str, Any]) -> T | None:
    """None where somebody has changed the facts, so that they make no sense."""
    try:
        return made(facts)
    except (InputError, KeyError, TypeError, ValueError):
        return None


def stamp_of(path: Path) -> Stamp:
    """Size and time of the last change of a file or folder."""
    try:
        found = os.stat(path)
    except (OSError, ValueError):
        return None
    return [found.st_size, found.st_mtime_ns]


def newest(paths: Iterable[Path]) -> int:
    """When any of these files has changed last, nanoseconds; 0 where there is none."""
    return max((stamp[1] for path in paths if (stamp := stamp_of(path)) is not None), default=0)
