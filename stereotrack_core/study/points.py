"""Points of a study: values that are tried together, of a grid or of a search with Optuna."""

from __future__ import annotations

import itertools
import logging
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from stereotrack_core.errors import InputError, did_you_mean
from stereotrack_core.parameters import ParameterRow, Value
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.presets import preset
from stereotrack_core.versions import extra_library

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
        remedy = "Give fewer values, or search for the best ones with --search."
        raise InputError(f"the grid has {count} points", "--grid", remedy)
    combinations = itertools.product(*(axis.values for axis in axes))
    return tuple(Point(tuple(zip(names, values, strict=True))) for values in combinations)


def varied_names(points: Iterable[Point]) -> tuple[str, ...]:
    """Names that any point gives a value to, in the order of their appearance; without seeds."""
    names = dict.fromkeys(name for point in points for name, _ in point.values)
    return tuple(name for name in names if name != "seed")


_FORM = "Write NAME=LOW:HIGH, NAME=LOW:HIGH:log or NAME=a,b,c."


@dataclass(frozen=True)
class Range:
    """A closed range in which one value is searched, or values that are chosen from."""

    name: str
    low: float = 0.0
    high: float = 0.0
    log: bool = False
    choices: tuple[Value, ...] = ()

    def suggested(self, trial: Any) -> Value:
        """The value that a trial of Optuna tries."""
        if self.choices:
            # by place, because Optuna wants no mixture of texts and numbers
            place = trial.suggest_categorical(self.name, list(range(len(self.choices))))
            return self.choices[int(place)]
        if parameter_rows()[self.name].type is int:
            return int(trial.suggest_int(self.name, round(self.low), round(self.high)))
        found = trial.suggest_float(self.name, self.low, self.high, log=self.log)
        return checked_value(self.name, found)


def parsed_range(text: str) -> Range:
    """Read what is given to ``--search``. Raises InputError."""
    name, sign, rest = text.partition("=")
    if not sign or not rest.strip():
        raise _wrong(text, "cannot be read")
    name = checked_name(name.strip(), "--search")
    if name == "seed":
        raise InputError("the seed cannot be searched", "--search", "Average over --seeds instead.")
    kind = parameter_rows()[name].type if name not in SPECIAL else str
    if ":" not in rest or kind not in (int, float):
        values = parsed_axis(text).values
        if len(values) < 2:
            raise _wrong(text, "has only one value")
        return Range(name, choices=values)
    low, high, *more = (part.strip() for part in rest.split(":"))
    if more not in ([], ["log"]):
        raise _wrong(text, "cannot be read")
    least, most = float(checked_value(name, low)), float(checked_value(name, high))
    if not least < most or (more and (kind is int or least <= 0.0)):
        raise _wrong(text, "is not a range")
    return Range(name, least, most, bool(more))


def _wrong(text: str, what: str) -> InputError:
    return InputError(
        f"{text!r} {what}",
        "--search",
        f"{_FORM} LOW must be the smaller value; log needs values above 0 that are not "
        "whole numbers only.",
    )


class Search:
    """Proposes points and learns from how good they are; a tree-structured Parzen estimator."""

    def __init__(self, ranges: Sequence[Range], *, more_is_better: bool = False) -> None:
        names = [one.name for one in ranges]
        if len(set(names)) < len(names):
            raise InputError("a name is given twice", "--search", "Give each name once.")
        missing = "Optuna is not installed, which is needed for a search"
        self._optuna = extra_library(
            "optuna", "search", missing=missing, where="--search", instead="--grid"
        )
        logging.getLogger("optuna").setLevel(logging.WARNING)
        self._study = self._optuna.create_study(
            sampler=self._optuna.samplers.TPESampler(seed=0, constant_liar=True),
            direction="maximize" if more_is_better else "minimize",
        )
        self._ranges = tuple(ranges)
        self._open: list[Any] = []

    def ask(self, count: int) -> tuple[Point, ...]:
        """The next points; :meth:`tell` is told about all of them together."""
        self._open = [self._study.ask() for _ in range(count)]
        asked = (tuple((r.name, r.suggested(trial)) for r in self._ranges) for trial in self._open)
        return tuple(Point(one) for one in asked)

    def tell(self, values: Sequence[float]) -> None:
        """How good the points were, in their order; NaN for one that failed."""
        for trial, value in zip(self._open, values, strict=True):
            if math.isfinite(value):
                self._study.tell(trial, value)
            else:
                self._study.tell(trial, state=self._optuna.trial.TrialState.FAIL)
