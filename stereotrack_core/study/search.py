"""Search for the best values with Optuna: each point is chosen from the results before it."""

from __future__ import annotations

import logging
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from stereotrack_core.errors import InputError
from stereotrack_core.parameters import Value
from stereotrack_core.study.points import (
    SPECIAL,
    Point,
    checked_name,
    checked_value,
    parameter_rows,
    parsed_axis,
)
from stereotrack_core.versions import extra_library

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
    """Read what is given to ``--search``.

    Raises InputError for an unknown name, or a range that the parameter does not have.
    """
    name, sign, rest = text.partition("=")
    if not sign or not rest.strip():
        raise _wrong(text, "cannot be read")
    name = checked_name(name.strip(), "--search")
    if name == "seed":
        raise InputError(
            "the seed cannot be searched", where="--search", remedy="Average over --seeds instead."
        )
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
        where="--search",
        remedy=f"{_FORM} LOW must be the smaller value; log needs values above 0 that are not "
        "whole numbers only.",
    )


class Search:
    """Proposes points and learns from how good they are; a tree-structured Parzen estimator."""

    def __init__(self, ranges: Sequence[Range], *, more_is_better: bool = False) -> None:
        names = [one.name for one in ranges]
        if len(set(names)) < len(names):
            raise InputError(
                "a name is given twice", where="--search", remedy="Give each name once."
            )
        self._optuna = extra_library(
            "optuna",
            "search",
            missing="Optuna is not installed, which is needed for a search",
            where="--search",
            instead="--grid",
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
        return tuple(
            Point(tuple((one.name, one.suggested(trial)) for one in self._ranges))
            for trial in self._open
        )

    def tell(self, values: Sequence[float]) -> None:
        """How good the points were, in their order; NaN for one that failed."""
        for trial, value in zip(self._open, values, strict=True):
            if math.isfinite(value):
                self._study.tell(trial, value)
            else:
                self._study.tell(trial, state=self._optuna.trial.TrialState.FAIL)
