"""A small histogram for each limb, beside each other on the same axes."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import pyqtgraph as pg
from PySide6.QtCore import QSize
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QGridLayout, QWidget

from stereotrack_core.arrays import FloatArray

from ..style.colours import LineStyle
from ..style.limb_colours import limb_words
from ..style.theme import Dressed, current_theme
from .plots import dress_plot, new_plot, pen_of, shade

_NARROWEST = 140
"""Pixels that a histogram has across at least, where there are several beside each other."""
_FILL = 110


@dataclass(frozen=True, eq=False)
class Steps:
    """How often one limb's values fall between `edges` (N + 1,): `height` (N,)."""

    name: str
    """The run."""
    place: int
    """0 for the active run, which is filled; others are lines."""
    limb: str
    colour: str
    style: LineStyle
    edges: FloatArray
    height: FloatArray


class Histograms(Dressed):
    """One plot for each limb; all runs of a limb lie over each other."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._steps: tuple[Steps, ...] = ()
        self._hidden: frozenset[str] = frozenset()
        self._columns = 1
        self._plots: dict[str, pg.PlotWidget] = {}
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setSpacing(0)
        self.setAccessibleName("Histogram of errors for each limb")

    def sizeHint(self) -> QSize:
        return QSize(420, 240)

    @property
    def plots(self) -> dict[str, pg.PlotWidget]:
        """Plots that are shown, by limb."""
        return {limb: plot for limb, plot in self._plots.items() if not plot.isHidden()}

    def show_steps(self, steps: Sequence[Steps], hidden: Collection[str] = ()) -> None:
        """Draw these, but for limbs that are `hidden`."""
        wanted = tuple(steps), frozenset(hidden)
        if wanted != (self._steps, self._hidden):
            self._steps, self._hidden = wanted
            self._draw()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        if self._columns != self._wanted_columns(len(self.plots)):
            self._arrange()

    def _wanted_columns(self, count: int) -> int:
        columns = max(1, min(count, self.width() // _NARROWEST))
        rows = -(-count // columns)
        return -(-count // rows) if rows else 1

    def _draw(self) -> None:
        shown = [one for one in self._steps if one.limb not in self._hidden]
        top = max((float(one.height.max(initial=0.0)) for one in shown), default=1.0)
        right = max((float(one.edges[-1]) for one in shown), default=1.0)
        limbs = dict.fromkeys(one.limb for one in shown)
        for limb in limbs:
            if limb not in self._plots:
                self._plots[limb] = _new_histogram(limb, self)
        for limb, plot in self._plots.items():
            plot.clear()
            for one in (one for one in shown if one.limb == limb):
                plot.addItem(_bars(one))
            plot.setXRange(0.0, right, padding=0.02)
            plot.setYRange(0.0, 1.05 * max(top, 1e-3), padding=0)
            plot.setVisible(limb in limbs)
        self._arrange()

    def _arrange(self) -> None:
        """Put the plots into as many columns as there is room for; numbers stand at the edges."""
        plots = list(self.plots.values())
        self._columns = columns = self._wanted_columns(len(plots))
        for place, plot in enumerate(plots):
            self._grid.addWidget(plot, *divmod(place, columns))
            plot.getAxis("left").setStyle(showValues=place % columns == 0)

    def _dress(self) -> None:
        for limb, plot in self._plots.items():
            _dress_histogram(plot, limb)


def _new_histogram(limb: str, parent: QWidget) -> pg.PlotWidget:
    plot = new_plot(parent)
    plot.setMouseEnabled(x=False, y=False)
    plot.setMinimumSize(80, 60)
    plot.setAccessibleName(f"Histogram of the errors of the {limb_words(limb)}")
    plot.getAxis("left").setWidth(30)
    plot.getAxis("bottom").setHeight(20)
    _dress_histogram(plot, limb)
    return plot


def _dress_histogram(plot: pg.PlotWidget, limb: str) -> None:
    dress_plot(plot)
    plot.setTitle(limb_words(limb), color=current_theme().text, size="9pt")


def _bars(steps: Steps) -> pg.PlotCurveItem:
    """Steps that are filled for the active run, and a line for others."""
    fill = {"fillLevel": 0.0, "brush": shade(steps.colour, _FILL)} if steps.place == 0 else {}
    pen = pen_of(steps.colour, steps.style, "usual")
    return pg.PlotCurveItem(steps.edges, steps.height, stepMode="center", pen=pen, **fill)
