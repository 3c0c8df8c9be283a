"""Points of a sweep: which values are tried together."""

from __future__ import annotations

import dataclasses
import itertools
import logging
import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal

from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError, did_you_mean
from stereotrack_core.experiments.runner.certificates import Certificates, certificates_of
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

MOST_POINTS = 100_000
"""More than this is taken for a slip."""


@dataclass(frozen=True)
class Point:
    """Values that are tried together, by name; what is not named stays as it is."""

    values: tuple[tuple[str, Value], ...] = ()
    """Tuple of (str, Value). In the order in which they were given."""

    @property
    def by_name(self) -> dict[str, Value]:
        """The values by their names."""
        return dict(self.values)

    @property
    def parameters(self) -> dict[str, Value]:
        """The values of declared parameters."""
        return {name: value for name, value in self.values if name not in SPECIAL}

    def special(self, name: str) -> str | None:
        """Value of one of :data:`SPECIAL` as text; None where the point does not say."""
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
            where=where,
            remedy=f"{did_you_mean(name, (*SPECIAL, *rows))}docs/parameters.md lists all "
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
        preset(text)  # refuses what is none; a file may hold one
    if not text:
        raise InputError("a value is missing", where=name, remedy="Write NAME=a,b,c.")
    return text


def parsed_axis(text: str) -> Axis:
    """Read ``NAME=a,b,c`` as given to ``--grid``.

    Raises InputError for an unknown name, a value outside its range, or a value given twice.
    """
    name, sign, values = text.partition("=")
    if not sign or not values.strip():
        raise InputError(f"{text!r} cannot be read", where="--grid", remedy="Write NAME=a,b,c.")
    name = checked_name(name.strip(), "--grid")
    checked = tuple(checked_value(name, value.strip()) for value in values.split(","))
    if len(set(checked)) < len(checked):
        raise InputError(
            f"{values!r} contains a value twice",
            where=f"--grid {name}",
            remedy="Give each value once.",
        )
    return Axis(name, checked)


def grid_points(axes: Sequence[Axis]) -> tuple[Point, ...]:
    """Every combination of the axes' values, the last axis fastest; without axes one point.

    Raises InputError for an axis given twice, or more points than anybody means.
    """
    names = [axis.name for axis in axes]
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise InputError(
            f"{twice} is given twice", where="--grid", remedy="Give all its values in one list."
        )
    count = 1
    for axis in axes:
        count *= len(axis.values)
    if count > MOST_POINTS:
        raise InputError(
            f"the grid has {count} points",
            where="--grid",
            remedy="Give fewer values, or search for the best ones with --search.",
        )
    combinations = itertools.product(*(axis.values for axis in axes))
    return tuple(Point(tuple(zip(names, values, strict=True))) for values in combinations)


def listed_points(
    columns: Sequence[str], rows: Iterable[Sequence[str]], where: str
) -> tuple[Point, ...]:
    """Points of a table whose columns are names; an empty cell leaves the value as it is.

    Raises InputError for an unknown name, a value outside its range, or no row at all.
    """
    names = [checked_name(name, where) for name in columns]
    points = []
    for number, row in enumerate(rows, start=2):
        try:
            values = [
                (name, checked_value(name, cell))
                for name, cell in zip(names, row, strict=True)
                if cell.strip()
            ]
        except InputError as error:
            raise InputError(
                error.what, where=f"{where}, line {number}, {error.where}", remedy=error.remedy
            ) from None
        points.append(Point(tuple(values)))
    if not points:
        raise InputError(
            "the list contains no points", where=where, remedy="Write one row per point."
        )
    return tuple(dict.fromkeys(points))


def varied_names(points: Iterable[Point]) -> tuple[str, ...]:
    """Names that any point gives a value to, in the order of their appearance; without seeds."""
    names = dict.fromkeys(name for point in points for name, _ in point.values)
    return tuple(name for name in names if name != "seed")


TRIALS = 30


@dataclass(frozen=True, kw_only=True)
class HowToTrack:
    """What a sweep and a study ask for alike, in the words of a person."""

    preset: str = "accurate"
    changes: tuple[str, ...] = ()
    """``NAME=VALUE`` for what differs from the preset."""
    seeds: str = "0"
    frames: str | None = None
    views: str | None = None
    """`frames` and `views`: none: all."""
    init: str = "auto"
    smooth: bool = False
    workers: int | None = None
    together: int | None = None
    """`workers` and `together`: processes on this machine, and jobs that one does together; None:
    as many as is good."""
    scheduler: str | None = None
    """Address of a Dask cluster; None: this machine."""
    tls_ca: Path | None = None
    tls_cert: Path | None = None
    tls_key: Path | None = None
    """`tls_ca`, `tls_cert` and `tls_key`: certificates for the cluster."""
    retries: int = 1
    again: bool = False
    """Compute also what is there already."""

    def certificates(self) -> Certificates | None:
        """Those that are given for the cluster. Raises InputError for those that cannot be used."""
        return certificates_of(self.scheduler, self.tls_ca, self.tls_cert, self.tls_key)

    def options_besides(self, own: Collection[str]) -> list[str]:
        """The options of the command that asks for this, but for attributes that are its own."""
        words: list[str] = []
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            name = {"points": "list", "changes": "set"}.get(field.name, field.name)
            option = f"--{name.replace('_', '-')}"
            if field.name in own or value is None or value is False:
                continue
            if value is True:
                words.append(option)
                continue
            for text in value if isinstance(value, tuple) else (value,):
                words += [option, str(text)]
        return words


@dataclass(frozen=True)
class SweepRequest(HowToTrack):
    """A sweep in the words of a person; see ``stereotrack sweep --help``."""

    recordings: tuple[Path, ...]
    table: Path
    """Where the results go."""
    grid: tuple[str, ...] = ()
    points: Path | None = None
    """A list of points; at most one of grid, list and search is given."""
    search: tuple[str, ...] = ()
    """`grid` and `search`: ``NAME=a,b,c`` and ``NAME=LOW:HIGH``."""
    trials: int = TRIALS
    search_seed: int = 0
    """`trials` and `search_seed`: points that a search tries, and its seed."""
    minimise: str | None = None
    """Measure that says which point is best; None: the usual one."""
    keypoints: tuple[Path, ...] = ()
    """Projects or files of detectors: none, or one for each recording in their order."""
    layout: str | None = None
    """Order of the points of files without names."""
    person: str | None = None
    """Name or number of the person in keypoints of several."""

    def check(self) -> None:
        """Refuse what does not go together, and numbers that mean nothing. Raises InputError."""
        least = {"workers": 1, "together": 1, "trials": 1, "retries": 0, "search_seed": 0}
        for name, low in least.items():
            value = getattr(self, name)
            if value is not None and value < low:
                option = f"--{name.replace('_', '-')}"
                raise InputError(
                    f"{value} is less than {low}", where=option, remedy=f"Give {low} or more."
                )
        if sum(map(bool, (self.grid, self.points, self.search))) > 1:
            raise InputError(
                "a sweep uses a grid, a list or a search",
                where="--grid, --list, --search",
                remedy="Use only one of them.",
            )
        if self.keypoints and len(self.keypoints) != len(self.recordings):
            raise InputError(
                f"keypoints are given {len(self.keypoints)} times for "
                f"{counted(len(self.recordings), 'recording')}",
                where="--keypoints",
                remedy="Give them once for each recording, in the order of the recordings.",
            )
        if self.scheduler and self.workers is not None:
            raise InputError(
                "a sweep runs on this machine or on a cluster",
                where="--workers, --scheduler",
                remedy="Use only one of them.",
            )
        self.certificates()
        if self.table.suffix.lower() != ".csv":
            raise InputError(
                "the table must be a CSV file",
                where=str(self.table),
                remedy="Use a name that ends in .csv.",
            )

    def arguments(self) -> list[str]:
        """The command that does the sweep."""
        own = {"recordings", "table"} | (set() if self.search else {"trials", "search_seed"})
        named = ("sweep", *map(str, self.recordings), "-o", str(self.table))
        return [*named, *self.options_besides(own)]


_FORM = "Write NAME=LOW:HIGH, NAME=LOW:HIGH:log, NAME=LOW:HIGH:int or NAME=a,b,c."


@dataclass(frozen=True)
class Range:
    """Where one value is looked for."""

    name: str
    low: float = 0.0
    high: float = 0.0
    """`low` and `high`: closed range; meaningless where there are choices."""
    scale: Literal["linear", "log", "int"] = "linear"
    """``linear``, ``log`` or ``int``."""
    choices: tuple[Value, ...] = ()
    """What is chosen from instead of a range."""

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


class Search:
    """Proposes points and learns from how good they are."""

    def __init__(self, ranges: Sequence[Range], seed: int, *, more_is_better: bool = False) -> None:
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
