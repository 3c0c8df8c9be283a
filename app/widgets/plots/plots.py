"""What all plots have in common: no menus of their own, the theme's colours, bands, grid."""

from __future__ import annotations

from html import escape
from typing import Any

import pyqtgraph as pg
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QWidget

from stereotrack_core.arrays import FloatArray, IntArray

from ..style.theme import current_theme

_GRID = 70
_SHADE = 45


def new_plot(parent: QWidget | None = None) -> pg.PlotWidget:
    """Make a plot without buttons and menu of its own."""
    plot = pg.PlotWidget(parent)
    plot.setMenuEnabled(False)
    plot.hideButtons()
    plot.getPlotItem().layout.setContentsMargins(6.0, 3.0, 8.0, 0.0)
    return plot


def dress_plot(plot: pg.PlotWidget, *, grid: bool = True) -> None:
    """Give ground, axes and grid the colours of the theme that is shown."""
    theme = current_theme()
    plot.setBackground(theme.plot_background)
    for name in ("left", "bottom"):
        axis = plot.getAxis(name)
        axis.setPen(theme.plot_grid)
        axis.setTextPen(theme.muted)
        if grid:
            axis.setGrid(_GRID)


def label_axis(plot: pg.PlotWidget, side: str, words: str) -> None:
    """Say beside an axis what it counts."""
    plot.setLabel(side, escape(words), color=current_theme().muted)


def shade(colour: str | QColor, alpha: int = _SHADE) -> QColor:
    """Return a colour that what lies behind can be seen through, `alpha` from 0 to 255."""
    result = QColor(colour)
    result.setAlpha(alpha)
    return result


def band(
    x: FloatArray | IntArray, low: FloatArray, high: FloatArray, colour: str
) -> tuple[Any, ...]:
    """Items that shade the stretch between two curves; all have to be added to the plot."""
    sides = [pg.PlotCurveItem(x, y, pen=None) for y in (low, high)]
    return (*sides, pg.FillBetweenItem(*sides, brush=shade(colour)))
