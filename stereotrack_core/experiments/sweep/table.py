"""A sweep's table as it is looked at: curves over one parameter, heat over two, as pictures too."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.atomic import write_file
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.summary import Spread
from stereotrack_core.experiments.measures import MEASURES, measure_named
from stereotrack_core.experiments.sweep.points import parameter_rows
from stereotrack_core.report.drawing import image_of

_FIXED = ("status", "frames", "attempts", "error", "job")
_LOG_FROM = 20.0
"""Values whose largest is so many times the smallest are spread over a logarithmic axis."""


@dataclass(frozen=True)
class SweepTable:
    """Rows of jobs that were done; every cell is text."""

    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    failed: int = 0
    """Jobs that were left out because they failed."""

    @property
    def parameters(self) -> tuple[str, ...]:
        """What was varied: columns that are no measures and have more than one value."""
        return tuple(name for name in self._told if len(self.values(name)) > 1)

    @property
    def settled(self) -> dict[str, str]:
        """Columns that are no measures and have the same value throughout."""
        return {name: self.values(name)[0] for name in self._told if len(self.values(name)) == 1}

    @property
    def _told(self) -> list[str]:
        known = {measure.name for measure in MEASURES} | set(_FIXED)
        return [name for name in self.columns if name not in known]

    @property
    def measures(self) -> tuple[str, ...]:
        """Measures of which something is known."""
        return tuple(
            measure.name
            for measure in MEASURES
            if measure.name in self.columns and np.isfinite(self.numbers(measure.name)).any()
        )

    def cells(self, name: str) -> list[str]:
        """A column, row by row."""
        place = self.columns.index(name)
        return [row[place] for row in self.rows]

    def values(self, name: str) -> tuple[str, ...]:
        """Different values of a column: numbers by size, words as they come."""
        found = tuple(dict.fromkeys(self.cells(name)))
        if all(_is_number(value) for value in found):
            return tuple(sorted(found, key=float))
        return found

    def numbers(self, name: str) -> FloatArray:
        """A column (R,) as numbers; NaN where there is none."""
        return np.array([float(c) if _is_number(c) else np.nan for c in self.cells(name)])

    def chosen(self, rows: Iterable[int]) -> dict[str, str]:
        """What some rows have in common of what was varied."""
        own = [self.rows[i] for i in rows]
        common = {}
        for name in self.parameters:
            found = {row[self.columns.index(name)] for row in own}
            if len(found) == 1:
                common[name] = found.pop()
        return common


@dataclass(frozen=True, eq=False)
class Axis:
    """Where values stand."""

    name: str
    places: dict[str, float]
    """By value. As a dictionary: numbers stand where they are, words side by
    side."""
    log: bool
    """Whether the axis is better logarithmic."""
    words: bool
    """Whether values are names, to be written at their places."""


@dataclass(frozen=True, eq=False)
class Curve:
    """Runs that agree in one parameter, over another one."""

    label: str
    """``views NS``; empty where there is one curve only."""
    x: FloatArray
    y: FloatArray
    """`x` and `y`: (N,). A point per run."""
    row: IntArray
    """(N,). Row of the table of each."""
    at: FloatArray
    mean: FloatArray
    spread: FloatArray
    """`at`, `mean` and `spread`: (M,). Where the mean line goes, and the standard deviation there
    (NaN for a single run)."""


@dataclass(frozen=True, eq=False)
class Heat:
    """Means over two parameters."""

    x: tuple[str, ...]
    y: tuple[str, ...]
    """`x` and `y`: values of both, in their order."""
    mean: FloatArray
    """(len(y), len(x)) float64. NaN where nothing was tried."""
    rows: tuple[tuple[tuple[int, ...], ...], ...]
    """Rows of the table behind each cell."""


def table_of_cells(columns: Sequence[str], rows: Sequence[Sequence[str]], where: str) -> SweepTable:
    """Take the cells of a CSV file for a sweep's table.

    Raises InputError where they are not, or no job was done.
    """
    if "job" not in columns or "status" not in columns:
        raise InputError(
            "this is not a sweep table",
            where=where,
            remedy="Choose a table written by `stereotrack sweep`.",
        )
    place = columns.index("status")
    done = tuple(tuple(row) for row in rows if row[place] == "done")
    if not done:
        raise InputError(
            "no job of this sweep is finished yet",
            where=where,
            remedy="Let the sweep continue first.",
        )
    return SweepTable(tuple(columns), done, failed=len(rows) - len(done))


def axis_of(table: SweepTable, name: str) -> Axis:
    """Where the values of a column stand."""
    values = table.values(name)
    if all(_is_number(value) for value in values):
        numbers = [float(value) for value in values]
        log = min(numbers) > 0 and max(numbers) >= _LOG_FROM * min(numbers)
        return Axis(name, dict(zip(values, numbers, strict=True)), log, words=False)
    return Axis(name, {value: float(i) for i, value in enumerate(values)}, False, words=True)


def curves_of(table: SweepTable, x: str, y: str, colour: str = "") -> tuple[Curve, ...]:
    """A measure over a parameter, one curve for each value of a third column, if one is given."""
    places = axis_of(table, x).places
    at = np.array([places[cell] for cell in table.cells(x)])
    height = table.numbers(y)
    labels = table.cells(colour) if colour else [""] * len(table.rows)
    curves = []
    for label in table.values(colour) if colour else ("",):
        own = np.array([one == label for one in labels]) & np.isfinite(height)
        if own.any():
            words = f"{colour.replace('_', ' ')} {label or '(unchanged)'}" if colour else ""
            curves.append(_curve(words, at[own], height[own], np.flatnonzero(own)))
    return tuple(curves)


def heat_of(table: SweepTable, x: str, y: str, measure: str) -> Heat:
    """Means of a measure over two parameters."""
    columns, lines = table.values(x), table.values(y)
    across, down = table.cells(x), table.cells(y)
    value = table.numbers(measure)
    cells = [
        [
            tuple(
                i
                for i in range(len(table.rows))
                if across[i] == column and down[i] == line and math.isfinite(value[i])
            )
            for column in columns
        ]
        for line in lines
    ]
    mean = np.array(
        [[value[list(cell)].mean() if cell else np.nan for cell in line] for line in cells]
    )
    return Heat(columns, lines, mean, tuple(tuple(line) for line in cells))


def best_cell(heat: Heat, measure: str) -> tuple[int, int] | None:
    """Line and column of the best mean; None where nothing is known."""
    known = measure_named(measure)
    if not np.isfinite(heat.mean).any():
        return None
    sign = -1.0 if known is not None and known.more_is_better else 1.0
    line, column = np.unravel_index(int(np.nanargmin(sign * heat.mean)), heat.mean.shape)
    return int(line), int(column)


def _curve(label: str, x: FloatArray, y: FloatArray, row: IntArray) -> Curve:
    at = np.unique(x)
    groups = [y[x == place] for place in at]
    found = [Spread.of(group) for group in groups]
    mean = np.array([one.mean for one in found])
    spread = np.array([one.deviation for one in found])
    return Curve(label, x, y, row, at, mean, spread)


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


_SIZE_INCHES = (6.4, 4.0)
_DPI = 200
_MOST_NUMBERS = 80
"""Heat maps with more cells have no numbers in them."""


def words_of(name: str) -> str:
    """How a column is called on an axis."""
    measure, row = measure_named(name), parameter_rows().get(name)
    if measure is not None:
        return measure.title
    unit = f" [{row.unit}]" if row is not None and row.unit else ""
    return f"{name.replace('_', ' ')}{unit}"


def draw_curves(path: Path, axis: Axis, measure: str, curves: tuple[Curve, ...]) -> None:
    """Write curves over a parameter as .png, .svg or .pdf; a file that is there is replaced."""
    figure, axes = _figure()
    for curve, colour in zip(curves, _colours(len(curves)), strict=True):
        axes.plot(curve.x, curve.y, ".", color=colour, alpha=0.35, markersize=5)
        spread = np.nan_to_num(curve.spread)
        axes.errorbar(
            curve.at, curve.mean, spread, color=colour, label=curve.label or None,
            marker="o", markersize=4, capsize=3, linewidth=1.4,
        )  # fmt: skip
    if axis.log:
        axes.set_xscale("log")
    axes.set_xticks(list(axis.places.values()), list(axis.places))
    axes.minorticks_off()
    axes.set_xlabel(words_of(axis.name))
    axes.set_ylabel(words_of(measure))
    axes.grid(alpha=0.3)
    if len(curves) > 1:
        figure.legend(frameon=False, loc="outside right upper")
    _write(path, figure)


def draw_heat(path: Path, names: tuple[str, str], measure: str, heat: Heat) -> None:
    """Write a heat map as .png, .svg or .pdf; `names` are those of both parameters."""
    figure, axes = _figure()
    image = axes.imshow(heat.mean, cmap="viridis", aspect="auto", origin="lower")
    axes.set_xticks(range(len(heat.x)), heat.x)
    axes.set_yticks(range(len(heat.y)), heat.y)
    axes.set_xlabel(words_of(names[0]))
    axes.set_ylabel(words_of(names[1]))
    figure.colorbar(image, label=words_of(measure))
    best = best_cell(heat, measure)
    if heat.mean.size <= _MOST_NUMBERS:
        middle = np.nanmean([np.nanmin(heat.mean), np.nanmax(heat.mean)])
        for (line, column), value in np.ndenumerate(heat.mean):
            if np.isfinite(value):
                axes.text(
                    column, line, f"{value:.3g}", ha="center", va="center",
                    color="white" if value < middle else "black",
                    weight="bold" if (line, column) == best else "normal",
                )  # fmt: skip
    _write(path, figure)


def _write(path: Path, figure: Any) -> None:
    write_file(path, image_of(figure, path.suffix.removeprefix("."), dpi=_DPI))


def _figure() -> tuple[Any, Any]:
    """A figure that belongs to no window."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=_SIZE_INCHES, layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.add_subplot()


def _colours(count: int) -> list[Any]:
    """From dark to bright in the order of the values."""
    from matplotlib import colormaps

    shades = np.linspace(0.1, 0.85, count) if count > 1 else np.array([0.3])
    return list(colormaps["viridis"](shades))
