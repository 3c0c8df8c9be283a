"""Read TOML so that every mistake becomes one sentence and reading goes on."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stereotrack_core.errors import InputError
from stereotrack_core.plain_data import DEEPEST, checked_tree
from stereotrack_core.reading import decoding, read_text

LARGEST = 10**9  # no number that these files hold is larger; beyond it, it is a slip

_NAME = r"""(?:[\w-]+|"[^"\n]*"|'[^'\n]*')"""
_DEEP_KEY = re.compile(rf"(?:^|[\[{{,])[ \t]*(?:{_NAME}[ \t]*\.[ \t]*){{{DEEPEST}}}", re.MULTILINE)
"""A key of so many parts that reading it would take for ever."""


def load_toml(path: Path) -> dict[str, Any]:
    """Content of a TOML file; InputError where it is none, or nested or large beyond reason."""
    text = read_text(path)
    with decoding(path, "this is not valid TOML", "Correct this line."):
        if _DEEP_KEY.search(text):
            raise RecursionError
        content = tomllib.loads(text)
    checked_tree(content, str(path))
    return content


@dataclass(frozen=True)
class Table:
    """A TOML table, `where` for people, that appends what is wrong to complaints it shares."""

    values: Mapping[str, Any]
    where: str
    complaints: list[InputError]

    def complain(self, key: str, what: str, remedy: str) -> None:
        """Note that the value of `key` is wrong."""
        place = f"{self.where}, {key}" if key else self.where
        self.complaints.append(InputError(what, place, remedy))

    def text(self, key: str, *, required: bool = False) -> str | None:
        """A non-empty text, or None."""
        value = self.values.get(key)
        if value is None:
            if required:
                self.complain(key, "the key is missing", f'Add {key} = "...".')
            return None
        if not isinstance(value, str) or not value.strip():
            self.complain(key, f"{value!r} is not a string", f'Write {key} = "...".')
            return None
        return value

    def number(self, key: str, default: float | None = None) -> float | None:
        """A finite number, `default` where the key is missing, None where it is wrong."""
        value = self.values.get(key, default)
        if value is None:
            return None
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        if not is_number or not math.isfinite(value):
            self.complain(key, f"{value!r} is not a finite number", f"Write {key} = a number.")
            return None
        if abs(value) > LARGEST:
            self.complain(key, f"{value:g} is too large", f"Write {key} = a smaller number.")
            return None
        return float(value)

    def numbers(self, key: str, count: int) -> tuple[float, ...]:
        """So many finite numbers; none where the list is missing or wrong."""
        value = self.values.get(key, ())
        if not isinstance(value, list | tuple) or len(value) != count:
            example = ", ".join(["0.0"] * count)
            self.complain(key, f"{value!r} is not {count} numbers", f"Write {key} = [{example}].")
            return ()
        named = {str(i): one for i, one in enumerate(value)}
        inner = Table(named, f"{self.where}, {key}", self.complaints)
        found = tuple(number for i in named if (number := inner.number(i)) is not None)
        return found if len(found) == count else ()

    def whole_number(self, key: str, default: int) -> int:
        """A whole number; `default` where it is missing or wrong."""
        value = self.values.get(key, default)
        if isinstance(value, bool) or not isinstance(value, int) or abs(value) > LARGEST:
            self.complain(key, f"{value!r} is not a whole number", f"Write {key} = {default}.")
            return default
        return value

    def table(self, key: str, *, required: bool = False, example: str = "...") -> Table | None:
        """A table below this one, or None."""
        value = self.values.get(key)
        if value is None:
            if required:
                self.complain(key, "the key is missing", f"Add {key} = {{ {example} }}.")
            return None
        if not isinstance(value, Mapping):
            self.complain(key, f"{value!r} is not a table", f"Write {key} = {{ {example} }}.")
            return None
        return Table(value, f"{self.where}, {key}", self.complaints)
