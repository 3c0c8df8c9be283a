"""A small error plot for each value of a parameter, on shared axes, and a curve of the means."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import (
    QColor,
    QFontMetricsF,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPen,
    QPolygonF,
)
from PySide6.QtWidgets import QSizePolicy, QWidget

from ..style.limb_colours import LIMB_COLOURS
from ..style.theme import current_theme

_CELL_WIDTH, _CELL_HEIGHT = 118, 84
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
        for limb, values in multiple.curves.items():
            painter.setPen(QPen(QColor(LIMB_COLOURS[limb]), 1.2))
            for part in _parts(multiple.frames, values, multiple.span, plot, top):
                painter.drawPolyline(part)

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


class MeansCurve(QWidget):
    """Mean error over the values, each above its place on the slider below."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._multiples: tuple[Multiple, ...] = ()
        self._current: int | None = None
        self.setFixedHeight(64)
        self.setAccessibleName("Mean error by value")
        self.setToolTip("Mean over the arm segments and frames, for each value.")

    def show_means(self, multiples: Sequence[Multiple], current: int | None) -> None:
        """Show the means of these plots."""
        self._multiples, self._current = tuple(multiples), current
        self.update()

    def points(self) -> list[QPointF | None]:
        """Where each mean is drawn; None where it is not known."""
        means = [m.mean for m in self._multiples]
        known = [mean for mean in means if math.isfinite(mean)]
        low, high = (min(known), max(known)) if known else (0.0, 1.0)
        room = max(high - low, 0.1)
        area = QRectF(self.rect()).adjusted(9, 18, -9, -6)
        step = area.width() / max(len(means) - 1, 1)
        return [
            QPointF(area.left() + k * step, area.bottom() - (mean - low) / room * area.height())
            if math.isfinite(mean)
            else None
            for k, mean in enumerate(means)
        ]

    def paintEvent(self, _event: QPaintEvent) -> None:
        theme, painter = current_theme(), QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.fillRect(self.rect(), QColor(theme.plot_background))
        places = self.points()
        known = [place for place in places if place is not None]
        painter.setPen(QPen(QColor(theme.muted), 1.4))
        painter.drawPolyline(QPolygonF(known))
        for k, (place, multiple) in enumerate(zip(places, self._multiples, strict=True)):
            if place is None:
                continue
            colour = theme.good if multiple.best else theme.text
            painter.setPen(
                QPen(QColor(theme.accent), 2.0) if k == self._current else QColor(colour)
            )
            painter.setBrush(QColor(colour))
            painter.drawEllipse(place, 3.5, 3.5)
            painter.setPen(QColor(colour))
            text = f"{multiple.mean:.1f}°"
            width = QFontMetricsF(self.font()).horizontalAdvance(text)
            x = min(max(place.x() - width / 2, 2.0), self.width() - width - 2.0)
            painter.drawText(QPointF(x, place.y() - 6.0), text)
        painter.end()


def _parts(
    frames: Sequence[int], values: Sequence[float], span: int, plot: QRectF, top: float
) -> list[QPolygonF]:
    """Lines of a curve, interrupted where nothing is known."""
    step = plot.width() / max(span - 1, 1)
    parts, line = [], QPolygonF()
    for frame, value in zip(frames, values, strict=True):
        if math.isfinite(value):
            y = plot.bottom() - min(value / top, 1.0) * plot.height()
            line.append(QPointF(plot.left() + frame * step, y))
        elif not line.isEmpty():
            parts.append(line)
            line = QPolygonF()
    return [*parts, line] if not line.isEmpty() else parts
