"""Search for the best point instead of trying a whole grid (tree-structured Parzen estimator).

Which points are tried depends on the seed, on the results, and on how many are asked for at once,
but not on how long anything takes: the same search gives the same points again, so that one that
was stopped goes on where it was by being done again with the results that there are.
Bergstra et al. 2011, Algorithms for hyper-parameter optimization (NeurIPS 24).
"""

from __future__ import annotations

import importlib
import logging
import math
from collections.abc import Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Any, Literal

from stereotrack_core.errors import InputError
from stereotrack_core.experiments.sweep.points import (
    SPECIAL,
    Point,
    checked_name,
    checked_value,
    parameter_rows,
)
from stereotrack_core.parameters import Value

_FORM = "Write NAME=LOW:HIGH, NAME=LOW:HIGH:log, NAME=LOW:HIGH:int or NAME=a,b,c."


@dataclass(frozen=True)
class Range:
    """Where one value is looked for.

    Attributes
    ----------
    low, high : float
        Closed range; meaningless where there are choices.
    scale : str
        ``linear``, ``log`` or ``int``.
    choices : tuple of Value
        What is chosen from instead of a range.
    """

    name: str
    low: float = 0.0
    high: float = 0.0
    scale: Literal["linear", "log", "int"] = "linear"
    choices: tuple[Value, ...] = ()

    def suggested(self, trial: Any) -> Value:
        """What a trial of the library tries."""
        if self.choices:
            # texts and numbers alike are stored by their place: the library wants no mixture
            place = trial.suggest_categorical(self.name, list(range(len(self.choices))))
            return self.choices[int(place)]
        if self.scale == "int":
            low, high = math.ceil(self.low), math.floor(self.high)
            return checked_value(self.name, trial.suggest_int(self.name, low, high))
        found = trial.suggest_float(self.name, self.low, self.high, log=self.scale == "log")
        return checked_value(self.name, found)


def parsed_range(text: str) -> Range:
    """Read what is given to ``--search``.

    Raises InputError for an unknown name, or a range that the parameter does not have.
    """
    where = "--search"
    name, sign, rest = text.partition("=")
    if not sign or not rest.strip():
        raise InputError(f"{text!r} cannot be read", where=where, remedy=_FORM)
    name = checked_name(name.strip(), where)
    if name == "seed":
        raise InputError(
            "the seed cannot be searched", where=where, remedy="Average over --seeds instead."
        )
    kind = parameter_rows()[name].type if name not in SPECIAL else str
    if ":" not in rest or kind not in (int, float):
        values = tuple(checked_value(name, part.strip()) for part in rest.split(","))
        if len(set(values)) < 2:
            raise InputError(f"{text!r} has only one value", where=where, remedy=_FORM)
        return Range(name, choices=tuple(dict.fromkeys(values)))
    return _numeric(name, rest, kind, text)


def _numeric(name: str, rest: str, kind: type, text: str) -> Range:
    where = "--search"
    parts = [part.strip() for part in rest.split(":")]
    scale = parts[2] if len(parts) == 3 else "int" if kind is int else "linear"
    if len(parts) > 3 or scale not in ("linear", "log", "int"):
        raise InputError(f"{text!r} cannot be read", where=where, remedy=_FORM)
    low, high = (float(checked_value(name, part)) for part in parts[:2])
    if not low < high or (scale == "log" and low <= 0.0):
        raise InputError(
            f"{text!r} is not a range",
            where=where,
            remedy="The first value must be the smaller one"
            + (", and above 0 for log." if scale == "log" else "."),
        )
    if scale == "int" and math.ceil(low) >= math.floor(high):
        raise InputError(f"{text!r} has only one value", where=where, remedy=_FORM)
    if kind is int and scale == "linear":
        scale = "int"
    if kind is int and scale == "log":
        raise InputError(
            f"{name} takes whole numbers",
            where=where,
            remedy=f"Write {name}={parts[0]}:{parts[1]}:int.",
        )
    return Range(name, low, high, scale)  # type: ignore[arg-type]  # checked above


def _optuna_library() -> ModuleType:
    """The library, which is an extra; InputError where it is not installed."""
    try:
        return importlib.import_module("optuna")
    except ImportError:
        raise InputError(
            "Optuna is not installed, which is needed for a search",
            where="--search",
            remedy="Install it with `pip install 'stereotrack[search]'`, or use --grid.",
        ) from None


class Search:
    """Proposes points and learns from how good they are.

    `more_is_better`: whether large values are wanted.
    """

    def __init__(self, ranges: Sequence[Range], seed: int, *, more_is_better: bool = False) -> None:
        names = [one.name for one in ranges]
        if len(set(names)) < len(names):
            raise InputError(
                "a name is given twice", where="--search", remedy="Give each name once."
            )
        self._optuna = _optuna_library()
        logging.getLogger("optuna").setLevel(logging.WARNING)
        sampler = self._optuna.samplers.TPESampler(seed=seed, constant_liar=True)
        self._study = self._optuna.create_study(
            sampler=sampler, direction="maximize" if more_is_better else "minimize"
        )
        self._ranges = tuple(ranges)
        self._open: list[tuple[Any, Point]] = []

    def ask(self, count: int) -> tuple[Point, ...]:
        """The next points, to be told about all together by :meth:`tell`."""
        self._open = []
        for _ in range(count):
            trial = self._study.ask()
            values = tuple((one.name, one.suggested(trial)) for one in self._ranges)
            self._open.append((trial, Point(values)))
        return tuple(point for _, point in self._open)

    def tell(self, values: Sequence[float]) -> None:
        """How good the points were, in their order; NaN where one failed."""
        for (trial, _), value in zip(self._open, values, strict=True):
            if math.isfinite(value):
                self._study.tell(trial, value)
            else:
                self._study.tell(trial, state=self._optuna.trial.TrialState.FAIL)
        self._open = []
