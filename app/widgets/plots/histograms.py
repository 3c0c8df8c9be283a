"""A small histogram for each limb, beside each other on the same axes."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import pyqtgraph as pg
from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QWidget

from stereotrack_core.arrays import FloatArray

from ..style.building import vbox
from ..style.colours import LineStyle
from ..style.limb_colours import limb_words
from ..style.theme import Dressed, current_theme
from .plots import dress_axes, pen_of, shade

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
        self.plots: dict[str, pg.PlotItem] = {}
        """By limb, those that are shown."""
        self._area = pg.GraphicsLayoutWidget()
        for part in (self._area, self._area.viewport()):
            part.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self._area.ci.setSpacing(2)
        self._area.ci.setContentsMargins(4, 0, 8, 0)
        self.setLayout(vbox(self._area))
        self.setAccessibleName("Histogram of errors for each limb")
        self._dress()

    def sizeHint(self) -> QSize:
        return QSize(420, 240)

    def show_steps(self, steps: Sequence[Steps], hidden: Collection[str] = ()) -> None:
        """Draw these, but for limbs that are `hidden`."""
        self._steps, self._hidden = tuple(steps), frozenset(hidden)
        self._draw()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        if self._columns != self._wanted_columns(len(self.plots)):
            self._draw()

    def _wanted_columns(self, count: int) -> int:
        columns = max(1, min(count, self.width() // _NARROWEST))
        rows = -(-count // columns)
        return -(-count // rows) if rows else 1

    def _draw(self) -> None:
        self._area.clear()
        shown = [one for one in self._steps if one.limb not in self._hidden]
        limbs = list(dict.fromkeys(one.limb for one in shown))
        self._columns = columns = self._wanted_columns(len(limbs))
        top = max((float(one.height.max(initial=0.0)) for one in shown), default=1.0)
        right = max((float(one.edges[-1]) for one in shown), default=1.0)
        self.plots = {}
        for place, limb in enumerate(limbs):
            plot = self._area.addPlot(*divmod(place, columns))
            self.plots[limb] = plot
            self._lay_out(plot, limb, left=place % columns == 0)
            for one in (one for one in shown if one.limb == limb):
                plot.addItem(_bars(one))
            plot.setXRange(0.0, right, padding=0.02)
            plot.setYRange(0.0, 1.05 * max(top, 1e-3), padding=0)

    def _lay_out(self, plot: pg.PlotItem, limb: str, *, left: bool) -> None:
        theme = current_theme()
        plot.setMenuEnabled(False)
        plot.hideButtons()
        plot.setMouseEnabled(x=False, y=False)
        plot.setTitle(limb_words(limb), color=theme.text, size="9pt")
        dress_axes(plot)
        plot.getAxis("left").setStyle(showValues=left)
        plot.getAxis("left").setWidth(30 if left else 6)
        plot.getAxis("bottom").setHeight(20)

    def _dress(self) -> None:
        self._area.setBackground(current_theme().plot_background)
        self._draw()


def _bars(steps: Steps) -> pg.PlotCurveItem:
    """Steps that are filled for the active run, and a line for others."""
    fill = {"fillLevel": 0.0, "brush": shade(steps.colour, _FILL)} if steps.place == 0 else {}
    pen = pen_of(steps.colour, steps.style, "usual")
    return pg.PlotCurveItem(steps.edges, steps.height, stepMode="center", pen=pen, **fill)
