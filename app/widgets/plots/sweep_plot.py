"""Curves and heat of a sweep; a click tells which runs are there."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QColor, QFont
from PySide6.QtWidgets import QStackedWidget, QWidget

from stereotrack_core.experiments.sweep.table import Axis, Curve, Heat, best_cell, words_of

from ..style.building import shortened, vbox
from ..style.theme import Dressed, current_theme
from .plots import dress_plot, label_axis, new_plot, shade

_MOST_NUMBERS = 80
_MOST_TICKS = 12
_LONGEST_TICK = 18
_LEGEND_SHARE = 0.32
"""Of the width of the curves, that the legend has beside them."""

_ASIDE = 0.06
"""Of the distance between values, that one curve stands aside of the next."""

_SHADES = {True: (0.42, 0.95), False: (0.05, 0.75)}
"""Part of the colour map that can be seen on a dark and on a bright ground."""


class SweepPlot(Dressed):
    """Draws curves with their points and spread, or a heat map."""

    rows_chosen = Signal(object)
    """Rows of the table behind what was clicked."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._shown: tuple[Any, ...] = ()
        self._heat: Heat | None = None
        self._curve_plot, self._heat_plot = new_plot(), new_plot()
        self._legend = self._curve_plot.addLegend(offset=(-10, 10))
        self._image = pg.ImageItem(axisOrder="row-major")
        self._numbers: list[pg.TextItem] = []
        self._heat_plot.addItem(self._image)
        self._bar = pg.ColorBarItem(
            colorMap=pg.colormap.get("viridis"), label=" ", interactive=False, width=16
        )
        self._bar.setImageItem(self._image, insert_in=self._heat_plot.plotItem)
        self._marks: list[pg.ScatterPlotItem] = []
        self._stack = QStackedWidget()
        for plot in (self._curve_plot, self._heat_plot):
            plot.getAxis("bottom").enableAutoSIPrefix(False)
            plot.getPlotItem().layout.setContentsMargins(6.0, 3.0, 8.0, 6.0)
            plot.scene().sigMouseClicked.connect(self._on_clicked)
            self._stack.addWidget(plot)
        self.setLayout(vbox(self._stack))
        self.setAccessibleName("Plot of a sweep")
        self.setMinimumSize(360, 240)

    def sizeHint(self) -> QSize:
        return QSize(720, 440)

    def show_curves(self, axis: Axis, measure: str, curves: Sequence[Curve]) -> None:
        """Draw a measure over one parameter."""
        self._shown = ("curves", axis, measure, tuple(curves))
        self._draw()

    def show_heat(self, names: tuple[str, str], measure: str, heat: Heat) -> None:
        """Draw means over two parameters, across and up."""
        self._shown = ("heat", names, measure, heat)
        self._draw()

    def place_of(self, x: float, y: float) -> Any:
        """Position in this widget of a point of the plot."""
        scene = self._plot.getViewBox().mapViewToScene(pg.Point(self._across(x), y))
        return self._plot.mapTo(self, self._plot.mapFromScene(scene))

    def _dress(self) -> None:
        if self._shown:
            self._draw()

    @property
    def _plot(self) -> pg.PlotWidget:
        """The plot that is shown."""
        return self._stack.currentWidget()

    # ---- drawing

    def _draw(self) -> None:
        kind, *rest = self._shown
        self._stack.setCurrentWidget(self._curve_plot if kind == "curves" else self._heat_plot)
        dress_plot(self._plot, grid=False)
        if kind == "curves":
            self._draw_curves(*rest)
        else:
            self._draw_heat(*rest)

    def _draw_curves(self, axis: Axis, measure: str, curves: tuple[Curve, ...]) -> None:
        self._plot.clear()
        self._legend.clear()
        self._marks.clear()
        self._heat = None
        self._label(axis.name, measure)
        self._plot.showGrid(y=True, alpha=0.25)
        aside = _asides(axis, len(curves))
        for curve, colour, shift in zip(curves, _shades(len(curves)), aside, strict=True):
            self._draw_curve(axis, curve, colour, shift)
        self._legend.setVisible(len(curves) > 1)
        self._legend.setLabelTextColor(current_theme().text)
        ticks = _ticks(axis)
        self._plot.getAxis("bottom").setLogMode(axis.log and ticks is None, False)
        self._plot.getAxis("bottom").setTicks(ticks)
        self._plot.getAxis("left").setTicks(None)
        self._show_all(axis, curves, max(aside, default=0.0))

    def _show_all(self, axis: Axis, curves: tuple[Curve, ...], aside: float) -> None:
        """Let everything be seen, beside the legend where there is one."""
        places = [_place(axis, value) for value in axis.places.values()]
        wide = _extent(axis)
        # half a step beside words, so that they can be read
        edge = aside + (0.5 if axis.words else 0.06 * wide)
        right = max(places) + edge
        if len(curves) > 1:
            right += _LEGEND_SHARE * (right - min(places) + edge)
        whole = np.concatenate([np.append(c.y, c.mean + np.nan_to_num(c.spread)) for c in curves])
        below = np.concatenate([c.mean - np.nan_to_num(c.spread) for c in curves])
        low, high = min(whole.min(), below.min()), whole.max()
        room = 0.05 * (high - low) or 1.0
        self._plot.setRange(
            xRange=(min(places) - edge, right), yRange=(low - room, high + room), padding=0
        )

    def _draw_curve(self, axis: Axis, curve: Curve, colour: QColor, shift: float) -> None:
        faint = shade(colour, 115)
        at = np.array([_place(axis, place) + shift for place in curve.at])
        half = np.nan_to_num(curve.spread)
        bars = pg.ErrorBarItem(
            x=at, y=curve.mean, top=half, bottom=half, pen=pg.mkPen(colour, width=1.2),
            beam=0.012 * _extent(axis),
        )  # fmt: skip
        points = pg.ScatterPlotItem(
            x=[_place(axis, place) + shift for place in curve.x], y=curve.y,
            data=curve.row.tolist(), size=7, pen=None, brush=faint, hoverable=True, tip=None,
        )  # fmt: skip
        line = pg.PlotDataItem(at, curve.mean, pen=pg.mkPen(colour, width=2))
        means = pg.ScatterPlotItem(
            x=at, y=curve.mean, data=[curve.row[curve.x == place].tolist() for place in curve.at],
            size=10, brush=colour, pen=current_theme().plot_background,
        )  # fmt: skip
        # a search tries other values each time: no line leads from one to the next
        joined = axis.words or len(curve.at) <= _MOST_TICKS
        for item in (bars, points, *([line] if joined else []), means):
            self._plot.addItem(item)
        if curve.label:
            self._legend.addItem(line, escape(_short(curve.label, 2 * _LONGEST_TICK)))
        self._marks += [means, points]

    def _draw_heat(self, names: tuple[str, str], measure: str, heat: Heat) -> None:
        theme = current_theme()
        self._heat = heat
        self._label(*names)
        self._image.setImage(heat.mean, autoLevels=False)
        self._image.setRect(-0.5, -0.5, len(heat.x), len(heat.y))
        low, high = _limits(heat)
        self._bar.setLevels((low, high))
        self._bar.axis.setLabel(words_of(measure), color=theme.muted)
        self._bar.axis.setTextPen(theme.muted)
        self._write_numbers(heat, measure, (low + high) / 2.0)
        for side, values in (("bottom", heat.x), ("left", heat.y)):
            ticks = [(float(i), _short(value)) for i, value in enumerate(values)]
            self._plot.getAxis(side).setTicks([_thinned(ticks)])
        self._plot.setRange(
            xRange=(-0.5, len(heat.x) - 0.5), yRange=(-0.5, len(heat.y) - 0.5), padding=0
        )

    def _write_numbers(self, heat: Heat, measure: str, middle: float) -> None:
        for text in self._numbers:
            self._plot.removeItem(text)
        self._numbers.clear()
        if heat.mean.size > _MOST_NUMBERS:
            return
        best = best_cell(heat, measure)
        for (line, column), value in np.ndenumerate(heat.mean):
            if np.isfinite(value):
                text = pg.TextItem(
                    f"{value:.3g}", color="white" if value < middle else "black", anchor=(0.5, 0.5)
                )
                font = QFont(self.font())
                font.setBold((line, column) == best)
                text.setFont(font)
                text.setPos(column, line)
                self._plot.addItem(text)
                self._numbers.append(text)

    def _label(self, across: str, up: str) -> None:
        for side, name in (("bottom", across), ("left", up)):
            label_axis(self._plot, side, words_of(name))

    def _across(self, x: float) -> float:
        if self._shown and self._shown[0] == "curves":
            return _place(self._shown[1], x)
        return x

    # ---- clicking

    def _on_clicked(self, event: Any) -> None:
        if event.button() != Qt.MouseButton.LeftButton:
            return
        box = self._plot.getViewBox()
        if not box.sceneBoundingRect().contains(event.scenePos()):
            return
        where = box.mapSceneToView(event.scenePos())
        if self._heat is not None:
            column, line = round(where.x()), round(where.y())
            if 0 <= line < len(self._heat.y) and 0 <= column < len(self._heat.x):
                self._choose(self._heat.rows[line][column])
            return
        for marks in self._marks:
            found = marks.pointsAt(marks.mapFromScene(event.scenePos()))
            if len(found):
                data = found[0].data()
                self._choose(tuple(data) if isinstance(data, list) else (int(data),))
                return

    def _choose(self, rows: tuple[int, ...]) -> None:
        if rows:
            self.rows_chosen.emit(rows)


def _place(axis: Axis, value: float) -> float:
    """Where a value of a parameter is drawn."""
    return float(np.log10(value)) if axis.log else float(value)


def _asides(axis: Axis, count: int) -> list[float]:
    """How far each curve stands aside, so that points of several do not hide each other."""
    places = sorted(_place(axis, value) for value in axis.places.values())
    gap = min(np.diff(places), default=1.0)
    step = min(_ASIDE * gap, 0.3 * gap / max(1, count))
    return [step * (i - (count - 1) / 2.0) for i in range(count)]


def _extent(axis: Axis) -> float:
    places = [_place(axis, value) for value in axis.places.values()]
    return max(places) - min(places) or 1.0


def _ticks(axis: Axis) -> list[list[tuple[float, str]]] | None:
    """A tick at each value where they are few or words; else the plot's own."""
    places = axis.places
    if not axis.words and len(places) > _MOST_TICKS:
        return None
    return [_thinned([(_place(axis, place), _short(value)) for value, place in places.items()])]


def _short(value: str, longest: int = _LONGEST_TICK) -> str:
    """A value that has room."""
    return shortened(value, longest) or "–"


def _thinned(ticks: list[tuple[float, str]]) -> list[tuple[float, str]]:
    """Ticks that have room; all are there where they are few."""
    step = max(1, len(ticks) // _MOST_TICKS)
    return ticks[::step]


def _limits(heat: Heat) -> tuple[float, float]:
    low, high = float(np.nanmin(heat.mean)), float(np.nanmax(heat.mean))
    return (low, high) if high > low else (low - 0.5, high + 0.5)


def _shades(count: int) -> list[QColor]:
    """Colours of curves, in the order of the values; no limb has them."""
    low, high = _SHADES[current_theme().is_dark]
    places = np.linspace(low, high, count) if count > 1 else [0.5 * (low + high)]
    colours = pg.colormap.get("viridis")
    return [colours.map(place, mode="qcolor") for place in places]
