"""Plain data, as JSON and TOML give them: how deep, how large, of which kinds."""

import dataclasses
import math
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from stereotrack_core.errors import InputError, shortened

DEEPEST = 32  # lists and tables within each other; no file of ours has ten
LARGEST_INTEGER = 2**63 - 1  # what TOML and all common programs can hold
Kind: TypeAlias = Any
"""What a value shall be: ``object`` for anything, ``str``, ``bool``, ``int``, ``float`` for any
finite number; ``[kind]`` for a list of such values, ``[kind, kind]`` for one of just these;
``{name: kind}`` for a table whose values may be missing, None or of their kind, ``{str: kind}`` for
one with any names; a tuple of kinds for any of them.
"""

_HALF_LETTER = re.compile("[\ud800-\udc7f\udd00-\udfff]")
"""But for those that stand for the bytes of a file's name that is no text."""

_Wrong: TypeAlias = tuple[tuple[Any, ...], Any, Kind]
_WORDS = {str: "a text", bool: "true or false", int: "a whole number", float: "a finite number"}


def checked_tree(content: Any, where: str) -> None:
    """Refuse endless nesting and numbers, halves of letters: InputError, which names the key."""
    waiting: list[tuple[Any, tuple[Any, ...]]] = [] if _is_sound(content) else [(content, ())]
    while waiting:
        value, place = waiting.pop()
        if isinstance(value, Mapping | list):
            if len(place) >= DEEPEST:
                remedy = f"Use at most {DEEPEST} levels of lists and tables."
                raise InputError("it is nested too deeply", _at(where, place[:3]), remedy)
            inner = value.items() if isinstance(value, Mapping) else enumerate(value)
            waiting += [(one, (*place, key)) for key, one in inner if not _is_sound(one)]
            if isinstance(value, Mapping):
                waiting += [(key, place) for key in value if not _is_sound(key)]
        elif isinstance(value, str):
            what = "a text contains invalid characters"
            raise InputError(what, _at(where, place), "Write the file again.")
        elif isinstance(value, int):
            what = f"a number of about {int(0.30103 * value.bit_length())} digits is too large"
            raise InputError(what, _at(where, place), "Write a smaller number.")


def check_kind(content: Any, kind: Kind, where: str, remedy: str) -> None:
    """Refuse plain data of another kind than they shall be: InputError, which names the key."""
    for place, value, wanted in _wrong(content, kind, ()):
        what = f"{shortened(repr(value))} is not {_said(wanted)}"
        raise InputError(what, _at(where, place), remedy)


def _wrong(value: Any, kind: Kind, place: tuple[Any, ...]) -> Iterator[_Wrong]:
    """Everything that is wrong, the first one first."""
    if not _is(value, kind):
        yield place, value, kind
    elif isinstance(kind, tuple):
        yield from _wrong(value, next(one for one in kind if _is(value, one)), place)
    elif isinstance(kind, Mapping):
        for key, one in value.items():
            own = kind.get(str, kind.get(key))
            if own is not None and one is not None:
                yield from _wrong(one, own, (*place, key))
    elif isinstance(kind, list):
        for i, one in enumerate(value):
            yield from _wrong(one, kind[i % len(kind)], (*place, i))


def _is(value: Any, kind: Kind) -> bool:
    """Whether a value is of a kind, whatever is within it."""
    if isinstance(kind, tuple):
        return any(_is(value, one) for one in kind)
    if isinstance(kind, Mapping):
        return isinstance(value, Mapping)
    if isinstance(kind, list):
        return isinstance(value, list) and (len(kind) == 1 or len(value) == len(kind))
    if kind is object:
        return True
    if kind is float:
        number = isinstance(value, int | float) and not isinstance(value, bool)
        return number and math.isfinite(value)
    return isinstance(value, kind) and (kind is bool or not isinstance(value, bool))


def _said(kind: Kind) -> str:
    if isinstance(kind, tuple):
        return " or ".join(_said(one) for one in kind)
    if isinstance(kind, Mapping):
        return "a table"
    if isinstance(kind, list):
        return "a list" if len(kind) == 1 else f"a list of {len(kind)} values"
    return _WORDS[kind]


def _is_sound(value: Any) -> bool:
    """Whether nothing is wrong with a value; False for what holds others."""
    if isinstance(value, int):
        return abs(value) <= LARGEST_INTEGER
    if isinstance(value, str):
        return value.isascii() or not _HALF_LETTER.search(value)
    return not isinstance(value, Mapping | list)


def _at(where: str, place: tuple[Any, ...]) -> str:
    names = [f"[{one}]" if isinstance(one, int) else f".{shortened(one)}" for one in place]
    return f"{where}, {''.join(names).removeprefix('.')}" if names else where


def plain(value: Any) -> Any:
    """The same value made of dictionaries, lists, texts and finite numbers."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: plain(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, str | bool | int | None):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Path):
        return str(value)
    return [plain(item) for item in value]
