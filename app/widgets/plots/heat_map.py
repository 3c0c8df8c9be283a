"""A matrix as colours, with names, groups, a colour bar, and the number under the mouse."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import (
    QColor,
    QFont,
    QFontMetricsF,
    QImage,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPen,
)
from PySide6.QtWidgets import QWidget

from stereotrack_core.arrays import FloatArray

from ..style.diverging import diverging_rgb
from ..style.limb_colours import LIMB_COLOURS
from ..style.theme import current_theme

_ROW, _LEAST_ROW, _TOP, _STRIP, _FOOT = 13.0, 11.0, 16.0, 4.0, 18.0
_BAR, _BAR_WORDS = 12.0, 22.0
_ARROWS = {
    Qt.Key.Key_Left: (0, -1),
    Qt.Key.Key_Right: (0, 1),
    Qt.Key.Key_Up: (-1, 0),
    Qt.Key.Key_Down: (1, 0),
}


@dataclass(frozen=True, eq=False)
class HeatMap:
    """Numbers with a sign as colours."""

    title: str
    rows: tuple[str, ...]
    """Names of the rows."""
    groups: tuple[tuple[str, str, int], ...]
    """Groups of successive columns: name, limb (empty for none) and how many."""
    values: FloatArray
    """(R, C) float64. -1 to 1: how strong the colour is."""
    words: Callable[[int, int], str]
    """From row and column to what is said about the number under the mouse."""
    ends: tuple[str, ...]
    """What the colours at both ends mean, with units: one line or more for each scale."""


class HeatMapView(QWidget):
    """Paints one :class:`HeatMap`; columns that are narrower than a pixel are averaged."""

    pointed = Signal(str)
    """What is said about the number under the mouse or chosen by arrow keys; empty for none."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._map: HeatMap | None = None
        self._cell: tuple[int, int] | None = None
        self.setMouseTracking(True)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAccessibleName("Matrix heat map")
        self.setAccessibleDescription("Use the arrow keys to move between cells.")

    def show_map(self, shown: HeatMap | None) -> None:
        """Show another matrix; the cell that is pointed at stays where there is one."""
        self._map = shown
        rows, columns = (0, 0) if shown is None else shown.values.shape
        if self._cell is not None and not (self._cell[0] < rows and self._cell[1] < columns):
            self._cell = None
        self.setMinimumHeight(round(_TOP + _STRIP + _FOOT + _LEAST_ROW * rows))
        self.updateGeometry()
        self.update()
        self._tell()

    def sizeHint(self) -> QSize:
        rows = 0 if self._map is None else len(self._map.rows)
        return QSize(320, round(_TOP + _STRIP + _FOOT + _ROW * rows))

    def words(self) -> str:
        """What is said about the cell that is pointed at."""
        if self._map is None or self._cell is None:
            return ""
        return self._map.words(*self._cell)

    def cell_place(self, row: int, column: int) -> QPointF:
        """Middle of a cell in the widget."""
        area, (rows, columns) = self._area(), self._shape()
        x = area.left() + (column + 0.5) * area.width() / max(columns, 1)
        return QPointF(x, area.top() + (row + 0.5) * area.height() / max(rows, 1))

    # ---- geometry

    def _shape(self) -> tuple[int, int]:
        if self._map is None:
            return 0, 0
        rows, columns = self._map.values.shape
        return int(rows), int(columns)

    def _small(self) -> QFont:
        font = QFont(self.font())
        rows = max(1, self._shape()[0])
        height = (self.height() - _TOP - _STRIP - _FOOT) / rows
        font.setPixelSize(int(np.clip(height, 9.0, 12.0)))
        return font

    def _area(self) -> QRectF:
        metrics = QFontMetricsF(self._small())
        names = () if self._map is None else self._map.rows
        left = max((metrics.horizontalAdvance(name) for name in names), default=0.0) + 6.0
        width = self.width() - left - _BAR - _BAR_WORDS - 8.0
        height = self.height() - _TOP - _STRIP - _FOOT
        return QRectF(left, _TOP + _STRIP, max(width, 1.0), max(height, 1.0))

    # ---- painting

    def paintEvent(self, _event: QPaintEvent) -> None:
        shown, theme = self._map, current_theme()
        if shown is None or not shown.values.size:
            return
        painter = QPainter(self)
        painter.setFont(self._small())
        area = self._area()
        pixels = np.ascontiguousarray(diverging_rgb(_fitted(shown, area.width()), theme))
        height, width = pixels.shape[:2]
        image = QImage(pixels.data, width, height, 3 * width, QImage.Format.Format_RGB888)
        painter.drawImage(area, image)
        self._paint_rows(painter, area, shown)
        self._paint_groups(painter, area, shown)
        self._paint_bar(painter, area, shown)
        self._paint_cell(painter, area)
        painter.end()

    def _paint_rows(self, painter: QPainter, area: QRectF, shown: HeatMap) -> None:
        step = area.height() / len(shown.rows)
        painter.setPen(QColor(current_theme().text))
        for i, name in enumerate(shown.rows):
            box = QRectF(0.0, area.top() + i * step, area.left() - 5.0, step)
            flags = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
            painter.drawText(box, flags | Qt.TextFlag.TextDontClip, name)

    def _paint_groups(self, painter: QPainter, area: QRectF, shown: HeatMap) -> None:
        theme, metrics = current_theme(), QFontMetricsF(painter.font())
        columns, at = shown.values.shape[1], 0
        for name, limb, count in shown.groups:
            x = area.left() + at * area.width() / columns
            width = count * area.width() / columns
            strip = QRectF(x + 0.5, _TOP, max(width - 1.0, 1.0), _STRIP - 1.0)
            painter.fillRect(strip, QColor(LIMB_COLOURS.get(limb, theme.disabled)))
            if at:
                painter.setPen(QPen(QColor(theme.border), 1.0))
                painter.drawLine(QPointF(x, area.top()), QPointF(x, area.bottom()))
            painter.setPen(QColor(theme.muted))
            for words in (name, _short(name)):
                if metrics.horizontalAdvance(words) <= width - 2.0:
                    box = QRectF(x, 0.0, width, _TOP)
                    painter.drawText(box, Qt.AlignmentFlag.AlignCenter, words)
                    break
            at += count
        painter.setPen(QPen(QColor(theme.border), 1.0))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawRect(area)

    def _paint_bar(self, painter: QPainter, area: QRectF, shown: HeatMap) -> None:
        theme = current_theme()
        bar = QRectF(area.right() + 8.0, area.top(), _BAR, area.height())
        column = diverging_rgb(np.linspace(1.0, -1.0, 101)[:, None], theme)
        image = QImage(column.data, 1, 101, 3, QImage.Format.Format_RGB888)
        painter.drawImage(bar, image)
        painter.setPen(QPen(QColor(theme.border), 1.0))
        painter.drawRect(bar)
        painter.setPen(QColor(theme.muted))
        for share, words in ((0.0, "+"), (0.5, "0"), (1.0, "−")):
            y = bar.top() + share * bar.height()
            box = QRectF(bar.right() + 3.0, y - 8.0 + 8.0 * (0.5 - share), 18.0, 16.0)
            painter.drawText(box, Qt.AlignmentFlag.AlignVCenter, words)
        said = "Colour scale: ± " + ", ".join(shown.ends)
        box = QRectF(0.0, area.bottom() + 2.0, self.width() - 2.0, _FOOT - 2.0)
        flags = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        painter.drawText(box, flags, said)

    def _paint_cell(self, painter: QPainter, area: QRectF) -> None:
        if self._cell is None:
            return
        rows, columns = self._shape()
        width, height = area.width() / columns, area.height() / rows
        middle = self.cell_place(*self._cell)
        box = QRectF(0.0, 0.0, max(width, 5.0), max(height, 5.0))
        box.moveCenter(middle)
        painter.setPen(QPen(QColor(current_theme().accent), 2.0))
        painter.drawRect(box)

    # ---- pointing

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        self._point_at(event.position())

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

    def _point_at(self, place: QPointF) -> None:
        area, (rows, columns) = self._area(), self._shape()
        if rows * columns and area.contains(place):
            row = int((place.y() - area.top()) / area.height() * rows)
            column = int((place.x() - area.left()) / area.width() * columns)
            self._cell = min(row, rows - 1), min(column, columns - 1)
        else:
            self._cell = None
        self._tell()

    def _tell(self) -> None:
        self.pointed.emit(self.words())
        self.update()


def _fitted(shown: HeatMap, width: float) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """Values, averaged over columns where there are more than pixels."""
    values = np.nan_to_num(shown.values)
    columns, pixels = values.shape[1], max(1, round(width))
    if columns <= pixels:
        return values
    edges = np.linspace(0, columns, pixels + 1).astype(np.int64)[:-1]
    return np.add.reduceat(values, edges, axis=1) / np.diff(np.append(edges, columns))


def _short(name: str) -> str:
    """``LU`` for ``left upper arm``."""
    return "".join(word[0] for word in name.split()[:2]).upper()
