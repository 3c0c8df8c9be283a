"""Read TOML so that every mistake becomes one sentence and reading goes on."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stereotrack_core.errors import InputError

LARGEST = 10**9
"""No number that these files hold is larger; beyond it, it is a slip."""


def load_toml(path: Path) -> dict[str, Any]:
    """Content of a TOML file.

    Raises
    ------
    InputError
        When the file is missing, unreadable, or not TOML.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise InputError(
            "the file does not exist", where=str(path), remedy="Add it or correct its path."
        ) from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(
            f"the file cannot be read ({reason(error)})",
            where=str(path),
            remedy=readable(error, "It has to be a UTF-8 text file."),
        ) from None
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(
            f"this is not valid TOML: {error}", where=str(path), remedy="Correct that line."
        ) from None


def reason(error: Exception, otherwise: str = "") -> str:
    """The reason within an error of the operating system or a codec, in a few words."""
    if isinstance(error, UnicodeDecodeError):
        return f"byte {error.start} is no text"
    return getattr(error, "strerror", None) or otherwise or type(error).__name__


def readable(error: Exception, otherwise: str) -> str:
    """What to do about a file that may not be read, else `otherwise`."""
    if isinstance(error, PermissionError):
        return "Give yourself the right to read it."
    return otherwise


@dataclass(frozen=True)
class Table:
    """A TOML table that collects complaints instead of stopping at the first.

    Attributes
    ----------
    values : mapping
    where : str
        File and section, as the user knows it.
    complaints : list of InputError
        Shared by all tables of one reading; what is wrong is appended.
    """

    values: Mapping[str, Any]
    where: str
    complaints: list[InputError]

    def complain(self, key: str, what: str, remedy: str) -> None:
        """Note that the value of `key` is wrong."""
        place = f"{self.where}, {key}" if key else self.where
        self.complaints.append(InputError(what, where=place, remedy=remedy))

    def text(self, key: str, *, required: bool = False) -> str | None:
        """A non-empty text, or None."""
        value = self.values.get(key)
        if value is None:
            if required:
                self.complain(key, "the key is missing", f'Add {key} = "...".')
            return None
        if not isinstance(value, str) or not value.strip():
            self.complain(key, f"{value!r} is not a text", f'Write {key} = "...".')
            return None
        return value

    def number(self, key: str, default: float | None = None) -> float | None:
        """A finite number, `default` where the key is missing, None where it is wrong."""
        value = self.values.get(key, default)
        if value is None:
            return None
        if (
            isinstance(value, bool)
            or not isinstance(value, int | float)
            or not math.isfinite(value)
        ):
            self.complain(key, f"{value!r} is not a finite number", f"Write {key} = a number.")
            return None
        if abs(value) > LARGEST:
            self.complain(key, f"{value:g} is too large", f"Write {key} = a smaller number.")
            return None
        return float(value)

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
