"""A state as named arrays, to be kept in a file, and a state from them.

A state is a frozen dataclass of arrays, numbers, texts and further states. Each number is named by
the path of its field, so that no class needs code of its own to be saved.
"""

import types
import typing
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from stereotrack_core.errors import InputError

Arrays: TypeAlias = Mapping[str, NDArray[Any]]  # arrays by name
T = TypeVar("T")


def saved(state: Any, name: str) -> dict[str, NDArray[Any]]:
    """Arrays of a state; fields that are None are left out, tuples state how long they are."""
    if state is None:
        return {}
    if is_dataclass(state):
        parts = {each.name: getattr(state, each.name) for each in fields(state)}
    elif isinstance(state, tuple):
        parts = {str(k): each for k, each in enumerate(state)}
    else:
        text = isinstance(state, str)
        return {name: np.frombuffer(state.encode(), np.uint8) if text else np.asarray(state)}
    found = {name: np.array(len(state))} if isinstance(state, tuple) else {}
    for part, value in parts.items():
        found |= saved(value, f"{name}.{part}")
    return found


def has_state(arrays: Arrays, name: str) -> bool:
    """Whether a state was saved under a name."""
    return any(key == name or key.startswith(f"{name}.") for key in arrays)


def restored(kind: type[T], arrays: Arrays, name: str) -> T:
    """State of a class that was saved under a name; InputError if the arrays do not fit."""
    try:
        state: T = _restored(kind, arrays, name)
    except (KeyError, ValueError, TypeError) as error:
        raise _foreign(str(error.args[0])) from None
    return state


def check_like(state: Any, arrays: Arrays, name: str) -> None:
    """Refuse arrays that no state of this one's model can have; raises InputError."""
    for key, own in saved(state, name).items():
        other = arrays.get(key)
        if other is None or other.ndim != own.ndim:
            raise _foreign(key)
        if key.endswith(".P") and other.shape != own.shape:
            raise _foreign(key)


def _foreign(which: str) -> InputError:
    return InputError(
        f"its tracker state does not belong to this version ({which})",
        remedy="Track the recording again. The frames in the file can still be evaluated and "
        "exported.",
    )


def _restored(kind: Any, arrays: Arrays, name: str) -> Any:
    origin, parts = typing.get_origin(kind), typing.get_args(kind)
    if origin in (types.UnionType, typing.Union):
        return _restored(parts[0], arrays, name) if has_state(arrays, name) else None
    if origin is tuple:
        count = int(arrays[name])
        each = [parts[0]] * count if parts[-1] is ... else parts
        return tuple(_restored(part, arrays, f"{name}.{k}") for k, part in enumerate(each))
    if is_dataclass(kind):
        hints = typing.get_type_hints(kind)
        return kind(
            **{  # type: ignore[operator]
                each.name: _restored(hints[each.name], arrays, f"{name}.{each.name}")
                for each in fields(kind)
            }
        )
    array = arrays[name]
    if kind is str:
        return array.tobytes().decode()
    return kind(array) if kind in (bool, int, float) else array
