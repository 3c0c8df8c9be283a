"""Parameters that are declared once.

A parameter is a field of a frozen dataclass made by :func:`parameter`. Validation, presets, the
command line's ``--set``, the tuning panel and the documentation are generated from that row.
"""

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, TypeVar, get_type_hints

from stereotrack_core.counting import typed_number, typed_whole_number
from stereotrack_core.errors import InputError, did_you_mean

Value = bool | int | float | str
ParametersT = TypeVar("ParametersT", bound="ParameterGroup")
T = TypeVar("T")
_ROW = "parameter"


@dataclass(frozen=True)
class ParameterRow:
    """What is declared about one parameter; `minimum` to `maximum` is the closed range."""

    name: str  # name for ``--set`` and the tuning panel; unique over all groups
    type: type  # ``bool``, ``int``, ``float`` or ``str``
    default: Any  # value where nothing else is said
    unit: str  # unit of the value as a person types it; empty for pure numbers
    minimum: float | None
    maximum: float | None
    choices: tuple[str, ...]  # for ``str``: the accepted words
    group: str  # heading in the panel and the documentation
    help: str  # one sentence that says what it does
    presets: Mapping[str, Value] = dataclasses.field(default_factory=dict)
    """Mapping from a preset's name to its value; where it is not the default. That of ``thesis``
    also where the thesis decides it, by section 4.2.1 or by its method, and it is the default."""

    @property
    def thesis(self) -> Value | None:
        """What the thesis says; None where it leaves that open."""
        return self.presets.get("thesis")

    def text(self, value: Value) -> str:
        """Value with its unit as a person reads it: ``20 deg``."""
        return f"{value_text(value).replace('_', ' ')} {self.unit}".strip()

    def words(self, value: Value) -> str:
        """Name and value as a person reads them: ``sigma joint 20 deg``."""
        return f"{self.name.replace('_', ' ')} {self.text(value)}"

    def matches(self, words: str) -> bool:
        """Whether its name, group or explanation has each of some words, in any case."""
        text = f"{self.name} {self.name.replace('_', ' ')} {self.group} {self.help}".lower()
        return all(word in text for word in words.lower().split())

    def checked(self, value: Value) -> Value:
        """Return `value` in the row's type, or raise :class:`InputError`."""
        converted = self._converted(value)
        if isinstance(converted, str):
            if self.choices and converted not in self.choices:
                raise self._refusal(value, f"one of {', '.join(self.choices)}")
        elif not isinstance(converted, bool):
            low, high = self.minimum, self.maximum
            outside = (low is not None and converted < low) or (
                high is not None and converted > high
            )
            if outside or (isinstance(converted, float) and not math.isfinite(converted)):
                raise self._refusal(value, f"a value {self.range_text()}")
        return converted

    def range_text(self) -> str:
        """Range in words, for messages and documentation."""
        unit = f" {self.unit}" if self.unit else ""
        match self.minimum, self.maximum:
            case None, None:
                return "of any size"
            case low, None:
                return f"from {low:g}{unit}"
            case None, high:
                return f"up to {high:g}{unit}"
            case low, high:
                return f"from {low:g} to {high:g}{unit}"
        raise AssertionError  # unreachable: the cases above are complete

    def _converted(self, value: Value) -> Value:
        try:
            if self.type is bool:
                return _as_bool(value)
            if self.type is int:
                if isinstance(value, float) and value != int(value):
                    raise ValueError
                return typed_whole_number(value) if isinstance(value, str) else int(value)
            if self.type is float:
                return typed_number(value) if isinstance(value, str) else float(value)
        except (TypeError, ValueError, OverflowError):
            raise self._refusal(value, f"a {_TYPE_WORDS[self.type]}") from None
        return str(value)

    def _refusal(self, value: Value, right: str) -> InputError:
        return InputError(f"{value!r} is not a valid value", self.name, f"Give {right}.")


def value_text(value: Value) -> str:
    """Write a value as a person types it."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:g}" if isinstance(value, float) else str(value)


_TYPE_WORDS = {bool: "yes or no", int: "whole number", float: "number", str: "word"}


def _as_bool(value: Value) -> bool:
    word = str(value).strip().lower()
    if word in {"true", "yes", "on", "1"}:
        return True
    if word in {"false", "no", "off", "0"}:
        return False
    raise ValueError


def parameter(
    default: Value,
    group: str,
    within: tuple[float | None, float | None] = (None, None),
    *,
    unit: str = "",
    choices: tuple[str, ...] = (),
    **presets: Value,
) -> Callable[[str], Any]:
    """Declare one parameter as a dataclass field; what is returned is given the help.

    See :class:`ParameterRow`; `within` is the closed range that is accepted, `presets` are the
    values of those that have another one.
    """
    minimum, maximum = within
    row = {
        "unit": unit,
        "minimum": minimum,
        "maximum": maximum,
        "choices": choices,
        "group": group,
        "presets": presets,
    }
    return lambda text: dataclasses.field(default=default, metadata={_ROW: row | {"help": text}})


@dataclass(frozen=True)
class ParameterGroup:
    """Base of dataclasses whose fields are parameters, or further groups."""

    @classmethod
    def rows(cls) -> tuple[ParameterRow, ...]:
        """All rows of this group and of the groups inside it, in order of declaration."""
        group: type = cls
        return _rows_of(group)

    def __post_init__(self) -> None:
        own = {field.name for field in dataclasses.fields(self)}
        for row in self.rows():
            if row.name in own:
                object.__setattr__(self, row.name, row.checked(getattr(self, row.name)))

    def values(self) -> dict[str, Value]:
        """Every value by its flat name."""
        result: dict[str, Value] = {}
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if isinstance(value, ParameterGroup):
                result |= value.values()
            else:
                result[field.name] = value
        return result

    def replaced(self: ParametersT, **values: Value) -> ParametersT:
        """Return a copy with values changed, named flatly; InputError for wrong names or values."""
        known = {row.name for row in self.rows()}
        for name in values:
            if name not in known:
                raise InputError(
                    f"unknown parameter {name!r}",
                    "--set",
                    did_you_mean(name, known).rstrip() or f"Available: {', '.join(sorted(known))}.",
                )
        return self._replaced(values)

    def _replaced(self: ParametersT, values: dict[str, Value]) -> ParametersT:
        changed: dict[str, Any] = {}
        for field in dataclasses.fields(self):
            old = getattr(self, field.name)
            if isinstance(old, ParameterGroup):
                changed[field.name] = old._replaced(values)
            elif field.name in values:
                changed[field.name] = values[field.name]
        return dataclasses.replace(self, **changed)


@cache
def _rows_of(group: type) -> tuple[ParameterRow, ...]:
    """All rows of a group, which take long to find out and never change."""
    hints, rows = get_type_hints(group), list[ParameterRow]()
    for field in dataclasses.fields(group):
        kind = hints[field.name]
        if isinstance(kind, type) and issubclass(kind, ParameterGroup):
            rows += kind.rows()
        else:
            rows.append(
                ParameterRow(field.name, kind, default=field.default, **field.metadata[_ROW])
            )
    return tuple(rows)


def parsed_settings(texts: Sequence[str]) -> dict[str, Value]:
    """Read ``NAME=VALUE`` as given to ``--set``."""
    result: dict[str, Value] = {}
    for text in texts:
        name, sign, value = text.partition("=")
        if not sign or not name.strip():
            raise InputError(f"{text!r} cannot be read", "--set", "Write NAME=VALUE.")
        result[name.strip()] = value.strip()
    return result
