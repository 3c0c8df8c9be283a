"""A small error plot for each value of a parameter, on shared axes, and a curve of the means."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import (
    QColor,
    QFontMetricsF,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPainterPath,
    QPaintEvent,
    QPen,
    QResizeEvent,
)
from PySide6.QtWidgets import QSizePolicy, QWidget

from ..style.building import vbox
from ..style.limb_colours import LIMB_COLOURS
from ..style.theme import Dressed, current_theme
from .plots import dress_plot, new_plot

_CELL_WIDTH, _CELL_HEIGHT = 118, 64
_PAD = 4.0
_LEAST_TOP = 20.0
"""Degrees that the shared axis shows at least."""


@dataclass(frozen=True)
class Multiple:
    """What was found with one value."""

    title: str
    summary: str
    """`title` and `summary`: the value, and its numbers."""
    frames: tuple[int, ...]
    """From the begin of the stretch."""
    curves: Mapping[str, tuple[float, ...]]
    """Mapping from limb to tuple of float. Degrees; NaN leaves a gap."""
    mean: float
    """Mean of the arms; NaN while frames are missing."""
    best: bool
    span: int = 1
    """Frames of the stretch."""

    @property
    def top(self) -> float:
        """Largest value of all curves."""
        known = [y for values in self.curves.values() for y in values if math.isfinite(y)]
        return max(known, default=0.0)


def keeps_arrows(event: QEvent) -> bool:
    """Whether an arrow key is meant for the widget that has the focus, and no shortcut."""
    if event.type() != QEvent.Type.ShortcutOverride or not isinstance(event, QKeyEvent):
        return False
    if event.key() not in (Qt.Key.Key_Left, Qt.Key.Key_Right) or event.modifiers():
        return False
    event.accept()
    return True


class SmallMultiples(QWidget):
    """Plots beside each other; a click, or the arrow keys, choose one."""

    chosen = Signal(int)
    taken = Signal(int)
    """A double click, or Enter."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._multiples: tuple[Multiple, ...] = ()
        self._current: int | None = None
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.MinimumExpanding)
        self.setAccessibleName("Errors for each value")
        self.setToolTip(
            "Errors of the limbs over frames for each value, on the same axes. Click a plot to "
            "show its model in the views; double-click to apply the value."
        )

    def show_multiples(self, multiples: Sequence[Multiple], current: int | None) -> None:
        """Show these plots, with one that is chosen."""
        self._multiples, self._current = tuple(multiples), current
        self.setMinimumHeight(self._rows() * _CELL_HEIGHT)
        self.setAccessibleDescription(
            "; ".join(f"{m.title}: {m.summary}{' (best)' if m.best else ''}" for m in multiples)
        )
        self.update()

    def sizeHint(self) -> QSize:
        return QSize(4 * _CELL_WIDTH, max(self._rows(), 1) * _CELL_HEIGHT)

    def area(self, place: int) -> QRectF:
        """Where a plot is drawn."""
        columns, rows = self._columns(), max(self._rows(), 1)
        width, height = self.width() / columns, self.height() / rows
        row, column = divmod(place, columns)
        return QRectF(column * width, row * height, width, height).adjusted(2, 2, -2, -2)

    def _columns(self) -> int:
        return max(1, min(len(self._multiples) or 1, self.width() // _CELL_WIDTH))

    def _rows(self) -> int:
        return -(-len(self._multiples) // self._columns())

    def event(self, event: QEvent) -> bool:
        return keeps_arrows(event) or super().event(event)

    def resizeEvent(self, _event: object) -> None:
        self.setMinimumHeight(self._rows() * _CELL_HEIGHT)

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        top = max([_LEAST_TOP, *(m.top for m in self._multiples)])
        for place, multiple in enumerate(self._multiples):
            self._draw(painter, self.area(place), multiple, top, place == self._current)
        painter.end()

    def _draw(
        self, painter: QPainter, area: QRectF, multiple: Multiple, top: float, current: bool
    ) -> None:
        theme = current_theme()
        painter.setBrush(QColor(theme.plot_background))
        edge = theme.accent if current else theme.good if multiple.best else theme.border
        painter.setPen(QPen(QColor(edge), 2.0 if current or multiple.best else 1.0))
        painter.drawRoundedRect(area, theme.radius, theme.radius)
        line = QFontMetricsF(self.font()).height()
        inner = area.adjusted(_PAD, 1, -_PAD, -1)
        painter.setPen(QColor(theme.good if multiple.best else theme.text))
        title = f"{multiple.title} – best" if multiple.best else multiple.title
        painter.drawText(inner, Qt.AlignmentFlag.AlignTop | Qt.AlignmentFlag.AlignHCenter, title)
        painter.setPen(QColor(theme.muted))
        metrics = QFontMetricsF(self.font())
        below = metrics.elidedText(multiple.summary, Qt.TextElideMode.ElideRight, inner.width())
        painter.drawText(inner, Qt.AlignmentFlag.AlignBottom | Qt.AlignmentFlag.AlignHCenter, below)
        plot = inner.adjusted(0, line, 0, -line)
        self._axis(painter, plot, top)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for limb, values in multiple.curves.items():
            painter.setPen(QPen(QColor(LIMB_COLOURS[limb]), 1.2))
            painter.drawPath(_line(multiple.frames, values, multiple.span, plot, top))

    def _axis(self, painter: QPainter, plot: QRectF, top: float) -> None:
        theme = current_theme()
        painter.setPen(QPen(QColor(theme.plot_grid), 1.0))
        painter.drawLine(plot.bottomLeft(), plot.bottomRight())
        for value in (45.0, 90.0):
            if value < top:
                y = plot.bottom() - value / top * plot.height()
                painter.drawLine(QPointF(plot.left(), y), QPointF(plot.right(), y))

    def place_at(self, position: QPointF) -> int | None:
        """Plot under a position."""
        found = (k for k in range(len(self._multiples)) if self.area(k).contains(position))
        return next(found, None)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        place = self.place_at(event.position())
        if place is not None and event.button() == Qt.MouseButton.LeftButton:
            self.chosen.emit(place)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        place = self.place_at(event.position())
        if place is not None:
            self.taken.emit(place)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        step = {Qt.Key.Key_Left: -1, Qt.Key.Key_Right: 1}.get(Qt.Key(event.key()))
        here = self._current
        if step is not None and self._multiples:
            place = 0 if here is None else here + step
            self.chosen.emit(min(max(place, 0), len(self._multiples) - 1))
        elif event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter) and here is not None:
            self.taken.emit(here)
        else:
            super().keyPressEvent(event)


class MeansCurve(Dressed):
    """Mean error over the values, each above its place on the slider below."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._last = 1
        self._shown: tuple[Sequence[Multiple], int | None] = (), None
        self._plot = new_plot(self)
        self._plot.getPlotItem().layout.setContentsMargins(0, 0, 0, 0)
        self._plot.hideAxis("left")
        self._plot.hideAxis("bottom")
        self._plot.setMouseEnabled(x=False, y=False)
        self.setLayout(vbox(self._plot))
        self.setFixedHeight(54)
        self.setAccessibleName("Mean error by value")
        self.setToolTip("Mean over the arm segments and frames, for each value.")

    def show_means(self, multiples: Sequence[Multiple], current: int | None) -> None:
        """Show the means of these plots."""
        self._shown = multiples, current
        theme = current_theme()
        self._plot.clear()
        dress_plot(self._plot, grid=False)
        known = [(k, m) for k, m in enumerate(multiples) if math.isfinite(m.mean)]
        if not known:
            return
        colours = [theme.good if m.best else theme.text for _, m in known]
        means = [m.mean for _, m in known]
        pens = zip((k for k, _ in known), colours, strict=True)
        curve = pg.PlotDataItem(
            [k for k, _ in known], means, pen=pg.mkPen(theme.muted, width=1.4),
            symbol="o", symbolSize=7, symbolBrush=colours,
            symbolPen=[pg.mkPen(theme.accent if k == current else c, width=2) for k, c in pens],
        )  # fmt: skip
        self._plot.addItem(curve)
        for (k, m), colour in zip(known, colours, strict=True):
            side = 0.0 if k == 0 else 1.0 if k == len(multiples) - 1 else 0.5
            text = pg.TextItem(f"{m.mean:.1f}°", color=colour, anchor=(side, 1.0))
            text.setPos(k, m.mean)
            self._plot.addItem(text, ignoreBounds=True)
        low, room = min(means), max(max(means) - min(means), 0.1)
        self._plot.setYRange(low - 0.15 * room, low + 1.7 * room, padding=0)
        self._last = max(len(multiples) - 1, 1)
        self._fit()

    def _dress(self) -> None:
        self.show_means(*self._shown)

    def _fit(self) -> None:
        """Let the ends stand where the slider's are."""
        edge = 9.0 * self._last / max(self.width() - 18, 1)
        self._plot.setXRange(-edge, self._last + edge, padding=0)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()


def _line(
    frames: Sequence[int], values: Sequence[float], span: int, plot: QRectF, top: float
) -> QPainterPath:
    """A curve, interrupted where nothing is known."""
    x = plot.left() + np.array(frames) * plot.width() / max(span - 1, 1)
    y = plot.bottom() - np.minimum(np.array(values) / top, 1.0) * plot.height()
    path: QPainterPath = pg.arrayToQPath(x, y, connect="finite")
    return path
