"""A sweep's curves and heat as a picture for a paper."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.atomic import write_file
from stereotrack_core.experiments.measures import measure_named
from stereotrack_core.experiments.sweep.points import parameter_rows
from stereotrack_core.experiments.sweep.table import Axis, Curve, Heat, best_cell
from stereotrack_core.report.drawing import image_of

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
    """Write curves as .png, .svg or .pdf.

    Parameters
    ----------
    path : Path
        A file that is replaced.
    axis : Axis
        Of the parameter.
    """
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
