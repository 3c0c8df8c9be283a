"""How often numbers of each size occur, as bars."""

from __future__ import annotations

from dataclasses import dataclass

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QFont, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QWidget

from stereotrack_core.arrays import FloatArray

from ..style.diverging import FULL_RESIDUAL, shade_colours, shade_of
from ..style.theme import current_theme

_HEIGHT, _FOOT, _SIDE = 110, 30.0, 8.0


@dataclass(frozen=True, eq=False)
class Histogram:
    """How often residuals of each size occur."""

    title: str
    edges: FloatArray
    """(B + 1,) float64. In the unit."""
    counts: FloatArray
    """(B,) float64."""
    shades: FloatArray
    """(B,) float64. -1 to 1: colour of each bar."""
    unit: str
    words: str
    """What is to be said about all of them."""
    sides: tuple[str, str] = ("", "")
    """What negative and positive numbers mean."""


class HistogramView(QWidget):
    """Paints one :class:`Histogram`; its bars have the colours of the lines in the views."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._shown: Histogram | None = None
        self.setMinimumHeight(_HEIGHT)
        self.setAccessibleName("Residuals")

    def show_histogram(self, shown: Histogram | None) -> None:
        """Show other numbers."""
        self._shown = shown
        self.setAccessibleDescription(shown.words if shown is not None else "")
        self.update()

    def sizeHint(self) -> QSize:
        return QSize(320, _HEIGHT)

    def paintEvent(self, _event: QPaintEvent) -> None:
        shown, theme = self._shown, current_theme()
        if shown is None or not len(shown.counts):
            return
        painter = QPainter(self)
        font = QFont(self.font())
        font.setPixelSize(11)
        painter.setFont(font)
        area = QRectF(_SIDE, 4.0, self.width() - 2 * _SIDE, self.height() - _FOOT - 4.0)
        highest = max(float(shown.counts.max()), 1.0)
        width = area.width() / len(shown.counts)
        colours = shade_colours()
        for i, count in enumerate(shown.counts.tolist()):
            height = count / highest * (area.height() - 2.0)
            bar = QRectF(area.left() + i * width, area.bottom() - height, width - 1.0, height)
            shade = int(shade_of(shown.shades[i : i + 1] * FULL_RESIDUAL)[0])
            painter.fillRect(bar, QColor(colours[shade]))
            painter.setPen(QPen(QColor(theme.border), 1.0))
            if height > 0.0:
                painter.drawRect(bar)
        painter.setPen(QPen(QColor(theme.muted), 1.0))
        painter.drawLine(area.bottomLeft(), area.bottomRight())
        self._paint_axis(painter, area, shown)
        painter.end()

    def _paint_axis(self, painter: QPainter, area: QRectF, shown: Histogram) -> None:
        first, last = float(shown.edges[0]), float(shown.edges[-1])
        for value in (first, 0.5 * (first + last), last):
            x = area.left() + (value - first) / (last - first) * area.width()
            painter.drawLine(QPointF(x, area.bottom()), QPointF(x, area.bottom() + 3.0))
            text = f"{value:.0f} {shown.unit}"
            if value in {first, last}:
                text = f"≤ {text}" if value == first and first < 0 else text
                text = f"≥ {text}" if value == last else text
            box = QRectF(x - 50.0, area.bottom() + 3.0, 100.0, 12.0)
            box.moveLeft(min(max(box.left(), 2.0), self.width() - 102.0))
            side = Qt.AlignmentFlag.AlignHCenter
            if value == first:
                side = Qt.AlignmentFlag.AlignLeft
            elif value == last:
                side = Qt.AlignmentFlag.AlignRight
            painter.drawText(box, side, text)
        if first < 0.0:
            below = QRectF(area.left(), area.bottom() + 15.0, area.width(), 13.0)
            painter.drawText(below, Qt.AlignmentFlag.AlignLeft, shown.sides[0])
            painter.drawText(below, Qt.AlignmentFlag.AlignRight, shown.sides[1])
