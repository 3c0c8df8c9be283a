"""Curves of a study: a measure over one of the varied names; a click tells which runs are there."""

from collections.abc import Callable, Sequence
from html import escape
from typing import Any

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QColor

from stereotrack_core.study.store import Curve, PlotAxis, words_of

from ..style.building import shortened, vbox
from ..style.theme import Dressed, current_theme
from .plots import dress_plot, label_axis, new_plot, shade

_MOST_TICKS = 12
_LONGEST_TICK = 18
_LEGEND_SHARE = 0.32  # share of the plot's width that the legend has beside the curves
_ASIDE = 0.06  # share of the distance between values that one curve is drawn aside of the next
_SHADES = {True: (0.42, 0.95), False: (0.05, 0.75)}
"""Part of the colour map that can be seen on a dark and on a bright ground."""


class StudyPlot(Dressed):
    """Draws curves with their points and spread.

    `choose` is called with a tuple of the rows of the table behind what was clicked.
    """

    def __init__(self, choose: Callable[[tuple[int, ...]], object]) -> None:
        super().__init__()
        self._choose = choose
        self._shown: tuple[PlotAxis, str, tuple[Curve, ...]] | None = None
        self._plot = new_plot()
        self._legend = self._plot.addLegend(offset=(-10, 10))
        self._marks: list[pg.ScatterPlotItem] = []
        self._plot.getAxis("bottom").enableAutoSIPrefix(False)
        self._plot.getPlotItem().layout.setContentsMargins(6.0, 3.0, 8.0, 6.0)
        self._plot.scene().sigMouseClicked.connect(self._on_clicked)
        self.setLayout(vbox(self._plot))
        self.setAccessibleName("Plot of a study")
        self.setMinimumSize(220, 110)

    def sizeHint(self) -> QSize:
        return QSize(720, 440)

    def show_curves(self, axis: PlotAxis, measure: str, curves: Sequence[Curve]) -> None:
        self._shown = axis, measure, tuple(curves)
        self._dress()

    def clear(self) -> None:
        self._shown = None
        self._dress()

    def _dress(self) -> None:
        dress_plot(self._plot)
        self._plot.clear()
        self._legend.clear()
        self._marks.clear()
        self._legend.setVisible(False)
        if self._shown is None:
            return
        axis, measure, curves = self._shown
        label_axis(self._plot, "bottom", words_of(axis.name))
        label_axis(self._plot, "left", words_of(measure))
        self._plot.showGrid(y=True, alpha=0.25)
        asides = _asides(axis, len(curves))
        for curve, colour, aside in zip(curves, _shades(len(curves)), asides, strict=True):
            self._draw_curve(axis, curve, colour, aside)
        self._legend.setVisible(len(curves) > 1)
        self._legend.setLabelTextColor(current_theme().text)
        ticks = _ticks(axis)
        self._plot.getAxis("bottom").setLogMode(axis.log and ticks is None, False)
        self._plot.getAxis("bottom").setTicks(ticks)
        if curves:
            self._show_all(axis, curves, max(asides, default=0.0))

    def _show_all(self, axis: PlotAxis, curves: tuple[Curve, ...], aside: float) -> None:
        places = [_place(axis, value) for value in axis.places.values()]
        # half a step beside words, so that they can be read
        edge = aside + (0.5 if axis.words else 0.06 * _extent(axis))
        right = max(places) + edge
        if len(curves) > 1:
            right += _LEGEND_SHARE * (right - min(places) + edge)
        spread = [np.nan_to_num(curve.spread) for curve in curves]
        ends = [(c.mean - s, c.mean + s, c.y) for c, s in zip(curves, spread, strict=True)]
        whole = np.concatenate([part for parts in ends for part in parts])
        low, high = whole.min(), whole.max()
        room = 0.05 * (high - low) or 1.0
        self._plot.setRange(
            xRange=(min(places) - edge, right), yRange=(low - room, high + room), padding=0
        )

    def _draw_curve(self, axis: PlotAxis, curve: Curve, colour: QColor, aside: float) -> None:
        at = np.array([_place(axis, place) + aside for place in curve.at])
        half = np.nan_to_num(curve.spread)
        bars = pg.ErrorBarItem(
            x=at, y=curve.mean, top=half, bottom=half, pen=pg.mkPen(colour, width=1.2),
            beam=0.012 * _extent(axis),
        )  # fmt: skip
        points = pg.ScatterPlotItem(
            x=[_place(axis, place) + aside for place in curve.x], y=curve.y,
            data=curve.row.tolist(), size=7, pen=None, brush=shade(colour, 115), hoverable=True,
            tip=None,
        )  # fmt: skip
        line = pg.PlotDataItem(at, curve.mean, pen=pg.mkPen(colour, width=2))
        means = pg.ScatterPlotItem(
            x=at, y=curve.mean, data=[curve.row[curve.x == place].tolist() for place in curve.at],
            size=10, brush=colour, pen=current_theme().plot_background,
        )  # fmt: skip
        # a search tries other values each time: no line leads from one to the next
        joined = axis.words or len(curve.at) <= 2 * _MOST_TICKS
        for item in (bars, points, *([line] if joined else []), means):
            self._plot.addItem(item)
        if curve.label:
            self._legend.addItem(line, escape(_short(curve.label, 2 * _LONGEST_TICK)))
        self._marks += [means, points]

    def _on_clicked(self, event: Any) -> None:
        if event.button() == Qt.MouseButton.LeftButton:
            at = (marks.pointsAt(marks.mapFromScene(event.scenePos())) for marks in self._marks)
            if found := next((points[0] for points in at if len(points)), None):
                rows = found.data()
                self._choose(tuple(rows) if isinstance(rows, list) else (int(rows),))


def _place(axis: PlotAxis, value: float) -> float:
    return float(np.log10(value)) if axis.log else float(value)


def _asides(axis: PlotAxis, count: int) -> list[float]:
    """Sideways offset of each curve, so that points of several do not hide each other."""
    places = sorted(_place(axis, value) for value in axis.places.values())
    gap = min(np.diff(places), default=1.0)
    step = min(_ASIDE * gap, 0.3 * gap / max(1, count))
    return [step * (i - (count - 1) / 2.0) for i in range(count)]


def _extent(axis: PlotAxis) -> float:
    places = [_place(axis, value) for value in axis.places.values()]
    return max(places) - min(places) or 1.0


def _ticks(axis: PlotAxis) -> list[list[tuple[float, str]]] | None:
    """A tick at each value if they are few or words; else None, for the plot's own."""
    ticks = [(_place(axis, place), _short(value)) for value, place in axis.places.items()]
    few = axis.words or len(ticks) <= 2 * _MOST_TICKS
    return [ticks[:: max(1, len(ticks) // _MOST_TICKS)]] if few else None


def _short(value: str, longest: int = _LONGEST_TICK) -> str:
    return shortened(value, longest) or "–"


def _shades(count: int) -> list[QColor]:
    """Colours of curves, in the order of the values; no limb has them."""
    low, high = _SHADES[current_theme().is_dark]
    places = np.linspace(low, high, count) if count > 1 else [0.5 * (low + high)]
    colours = pg.colormap.get("viridis")
    return [colours.map(place, mode="qcolor") for place in places]
