"""Points of a study: values that are tried together."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from stereotrack_core.errors import InputError, did_you_mean
from stereotrack_core.parameters import ParameterRow, Value
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.presets import preset

SPECIAL: Mapping[str, str] = MappingProxyType(
    {
        "views": "views to use, as for --views",
        "preset": "preset that the parameters come from",
        "seed": "random seed",
        "frames": "frame range, A:B",
        "init": "initial pose: auto, tpose or a file",
        "smooth": "whether the run is smoothed",
    }
)
"""What can be varied beside the declared parameters."""

_MOST_POINTS = 100_000  # a grid with more points is taken for a slip


@dataclass(frozen=True)
class Point:
    """Values that are tried together, by name; what is not named stays as it is."""

    values: tuple[tuple[str, Value], ...] = ()

    @property
    def by_name(self) -> dict[str, Value]:
        """The values by their names."""
        return dict(self.values)

    @property
    def parameters(self) -> dict[str, Value]:
        """The values of declared parameters."""
        return {name: value for name, value in self.values if name not in SPECIAL}

    @property
    def without_seed(self) -> Point:
        """The point that runs with other seeds share."""
        return Point(tuple(one for one in self.values if one[0] != "seed"))

    def special(self, name: str) -> str | None:
        """Value of one of :data:`SPECIAL` as text; None if the point does not say."""
        value = self.by_name.get(name)
        return None if value is None else str(value)


@dataclass(frozen=True)
class Axis:
    """A name and the values that are tried."""

    name: str
    values: tuple[Value, ...]


def parameter_rows() -> dict[str, ParameterRow]:
    """Every declared parameter by name."""
    return {row.name: row for row in Settings.rows()}


def checked_name(name: str, where: str) -> str:
    """The name of something that can be varied. Raises InputError for anything else."""
    rows = parameter_rows()
    if name not in rows and name not in SPECIAL:
        raise InputError(
            f"unknown parameter {name!r}",
            where,
            f"{did_you_mean(name, (*SPECIAL, *rows))}docs/parameters.md lists all "
            f"parameters; also allowed: {', '.join(SPECIAL)}.",
        )
    return name


def checked_value(name: str, value: Value) -> Value:
    """A value as its row wants it. Raises InputError for a value that is not accepted."""
    if name not in SPECIAL:
        return parameter_rows()[name].checked(value)
    text = str(value).strip()
    if name == "smooth":
        return ParameterRow(name, bool, False, "", None, None, (), "", SPECIAL[name]).checked(text)
    if name == "seed":
        return ParameterRow(name, int, 0, "", 0, None, (), "", SPECIAL[name]).checked(text)
    if name == "preset":
        preset(text)  # refuses an unknown one
    if not text:
        raise InputError("a value is missing", name, "Write NAME=a,b,c.")
    return text


def parsed_axis(text: str) -> Axis:
    """Read ``NAME=a,b,c`` as given to ``--grid``. Raises InputError."""
    name, sign, values = text.partition("=")
    if not sign or not values.strip():
        raise InputError(f"{text!r} cannot be read", "--grid", "Write NAME=a,b,c.")
    name = checked_name(name.strip(), "--grid")
    checked = tuple(checked_value(name, value.strip()) for value in values.split(","))
    if len(set(checked)) < len(checked):
        what = f"{values!r} contains a value twice"
        raise InputError(what, f"--grid {name}", "Give each value once.")
    return Axis(name, checked)


def grid_points(axes: Sequence[Axis]) -> tuple[Point, ...]:
    """Every combination of the axes' values, the last axis fastest. Raises InputError."""
    names = [axis.name for axis in axes]
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise InputError(f"{twice} is given twice", "--grid", "Give all its values in one list.")
    count = math.prod(len(axis.values) for axis in axes)
    if count > _MOST_POINTS:
        raise InputError(f"the grid has {count} points", "--grid", "Give fewer values.")
    combinations = itertools.product(*(axis.values for axis in axes))
    return tuple(Point(tuple(zip(names, values, strict=True))) for values in combinations)


def varied_names(points: Iterable[Point]) -> tuple[str, ...]:
    """Names that any point gives a value to, in the order of their appearance; without seeds."""
    names = dict.fromkeys(name for point in points for name, _ in point.values)
    return tuple(name for name in names if name != "seed")
