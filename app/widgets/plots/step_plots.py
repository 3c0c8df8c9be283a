"""A matrix as colours."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QEvent, QPointF, Qt, Signal
from PySide6.QtGui import QFont, QFontMetricsF, QKeyEvent, QMouseEvent, QResizeEvent
from PySide6.QtWidgets import QWidget

from stereotrack_core.arrays import FloatArray

from ..style.building import vbox
from ..style.colours import LIMB_COLOURS, diverging_rgb
from ..style.theme import Dressed, current_theme
from .plots import dress_plot, label_axis, new_plot

_LEAST_ROW, _BESIDE = 11, 62
_STRIP = 0.4
"""Rows that the strips in the colours of the groups take above the matrix."""

_ARROWS = {
    Qt.Key.Key_Left: (0, -1),
    Qt.Key.Key_Right: (0, 1),
    Qt.Key.Key_Up: (-1, 0),
    Qt.Key.Key_Down: (1, 0),
}


@dataclass(frozen=True, eq=False)
class HeatMap:
    """Numbers with a sign as colours."""

    rows: tuple[str, ...]
    """Names of the rows."""
    groups: tuple[tuple[str, str, int], ...]
    """Groups of successive columns: name, limb (empty for none) and how many."""
    values: FloatArray
    """(R, C) float64. -1 to 1: how strong the colour is."""
    words: Callable[[int, int], str]
    """From row and column to what is said about the number under the mouse."""


class HeatMapView(Dressed):
    """Draws one :class:`HeatMap`; columns that are narrower than a pixel are averaged."""

    pointed = Signal(str)
    """What is said about the number under the mouse or chosen by arrow keys; empty for none."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._map: HeatMap | None = None
        self._cell: tuple[int, int] | None = None
        self._plot = new_plot(self)
        # the page scrolls, and this widget points
        self._plot.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self._plot.showAxis("top")
        self._box = self._plot.getViewBox()
        self._box.invertY()
        self._image = pg.ImageItem(axisOrder="row-major", autoDownsample=True)
        self._bar = pg.ColorBarItem(values=(-1.0, 1.0), interactive=False, width=12)
        self._bar.setImageItem(self._image, insert_in=self._plot.getPlotItem())
        self._bar.axis.setTicks([[(-1.0, "−"), (0.0, "0"), (1.0, "+")]])
        self._mark = pg.PlotCurveItem()
        self._mark.setZValue(10)
        self.setLayout(vbox(self._plot))
        self.setMouseTracking(True)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAccessibleName("Matrix heat map")
        self.setAccessibleDescription("Use the arrow keys to move between cells.")

    def show_map(self, shown: HeatMap | None) -> None:
        """Show another matrix; the cell that is pointed at stays where there is one."""
        self._map = shown
        rows, columns = self._shape()
        if self._cell is not None and not (self._cell[0] < rows and self._cell[1] < columns):
            self._cell = None
        self.setMinimumHeight(_BESIDE + _LEAST_ROW * rows)
        self._dress()
        self._tell()

    def words(self) -> str:
        """What is said about the cell that is pointed at."""
        if self._map is None or self._cell is None:
            return ""
        return self._map.words(*self._cell)

    def cell_place(self, row: int, column: int) -> QPointF:
        """Middle of a cell in the widget."""
        scene = self._box.mapViewToScene(QPointF(column + 0.5, row + 0.5))
        return QPointF(self._plot.mapTo(self, self._plot.mapFromScene(scene)))

    def _shape(self) -> tuple[int, int]:
        rows, columns = (0, 0) if self._map is None else self._map.values.shape
        return int(rows), int(columns)

    def _dress(self) -> None:
        """Draw everything in the theme's colours."""
        self._plot.clear()
        shown, theme, (rows, columns) = self._map, current_theme(), self._shape()
        if shown is None or not shown.values.size:
            return
        dress_plot(self._plot, grid=False)
        shades = diverging_rgb(np.linspace(-1.0, 1.0, 255), theme)
        self._bar.setColorMap(pg.ColorMap(None, shades))
        self._bar.axis.setTextPen(theme.muted)
        self._image.setImage(np.nan_to_num(shown.values), levels=(-1.0, 1.0))
        self._image.setRect(0.0, 0.0, columns, rows)
        ends = np.cumsum([count for *_, count in shown.groups])
        starts = ends - [count for *_, count in shown.groups]
        colours = [LIMB_COLOURS.get(limb, theme.disabled) for _, limb, _ in shown.groups]
        strips = pg.BarGraphItem(
            x0=starts, x1=ends, y0=-_STRIP, y1=-0.1, brushes=colours, pen=theme.plot_background
        )
        self._mark.setPen(pg.mkPen(theme.accent, width=2))
        borders = [pg.InfiniteLine(x, pen=theme.border) for x in starts[1:].tolist()]
        for item in (self._image, strips, *borders, self._mark):
            self._plot.addItem(item)
        self._box.setRange(xRange=(0.0, columns), yRange=(-_STRIP, rows), padding=0)
        label_axis(self._plot, "bottom", "Colour scale: ± correlation 1")
        self._write_names(shown)

    def _write_names(self, shown: HeatMap) -> None:
        font = QFont(self.font())
        height = (self.height() - _BESIDE) / max(len(shown.rows), 1)
        font.setPixelSize(int(np.clip(height, 9.0, 12.0)))
        for name in ("left", "top", "bottom"):
            axis = self._plot.getAxis(name)
            axis.setStyle(tickFont=font, tickLength=0, hideOverlappingLabels=False)
        named = [(place + 0.5, name) for place, name in enumerate(shown.rows)]
        self._plot.getAxis("left").setTicks([named])
        self._plot.getAxis("bottom").setTicks([])
        top, metrics, at, names = self._plot.getAxis("top"), QFontMetricsF(font), 0, []
        pixels = self._box.width() / max(self._shape()[1], 1)
        for name, _, count in shown.groups:
            fits = metrics.horizontalAdvance(name) <= count * pixels - 2.0
            names.append((at + 0.5 * count, name if fits else _short(name)))
            at += count
        top.setTextPen(current_theme().muted)
        top.setTicks([names])

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        if self._map is not None:
            self._write_names(self._map)

    # ---- pointing

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        scene = self._plot.mapToScene(self._plot.mapFrom(self, event.position().toPoint()))
        place, (rows, columns) = self._box.mapSceneToView(scene), self._shape()
        row, column = int(np.floor(place.y())), int(np.floor(place.x()))
        inside = 0 <= row < rows and 0 <= column < columns
        self._cell = (row, column) if inside else None
        self._tell()

    def leaveEvent(self, event: QEvent) -> None:
        super().leaveEvent(event)
        self._cell = None
        self._tell()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        move = _ARROWS.get(Qt.Key(event.key()))
        rows, columns = self._shape()
        if move is None or not rows * columns:
            super().keyPressEvent(event)
            return
        row, column = self._cell or (0, 0)
        if self._cell is not None:
            row, column = row + move[0], column + move[1]
        self._cell = min(max(row, 0), rows - 1), min(max(column, 0), columns - 1)
        self._tell()

    def _tell(self) -> None:
        self._mark.setVisible(self._cell is not None)
        if self._cell is not None:
            y, x = self._cell
            self._mark.setData([x, x + 1, x + 1, x, x], [y, y, y + 1, y + 1, y])
        self.pointed.emit(self.words())


def _short(name: str) -> str:
    """``LU`` for ``left upper arm``."""
    return "".join(word[0] for word in name.split()[:2]).upper()
