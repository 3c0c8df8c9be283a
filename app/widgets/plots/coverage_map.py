"""Where in a camera's image the board was seen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QSizePolicy, QWidget

from stereotrack_core.arrays import BoolArray, FloatArray

from ..style.theme import Theme, current_theme

_ROOM = 22.0
"""Pixels below the map for its words."""


@dataclass(frozen=True, eq=False)
class CoverageShown:
    """An image of `size` (width, height), the `cells` (r, c) reached, and `corners` (n, 2)."""

    title: str
    size: tuple[int, int]
    cells: BoolArray
    corners: FloatArray
    """Raw pixels, none of them NaN."""


class CoverageMap(QWidget):
    """Cells of the image that hold corners, and the corners themselves."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.shown: CoverageShown | None = None
        self.setMinimumSize(140, 80)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setAccessibleName("Coverage of the image")
        self.setToolTip(
            "Dots: all corners of the board in this camera's pictures. Cells without a colour: "
            "the board was never there, so that the distortion is a guess."
        )

    def sizeHint(self) -> QSize:
        return QSize(280, 220)

    def show_coverage(self, shown: CoverageShown | None) -> None:
        """Show this, or nothing."""
        self.shown = shown
        self.setAccessibleDescription("" if shown is None else shown.title)
        self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter, theme = QPainter(self), current_theme()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if self.shown is None:
            painter.setPen(QColor(theme.muted))
            words = "Calculate the lenses to see where in the image the board was."
            flags = Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap
            painter.drawText(self.rect().adjusted(12, 12, -12, -12), flags, words)
        else:
            _paint(painter, self.shown, QRectF(self.rect()), theme)
        painter.end()


def _paint(painter: QPainter, shown: CoverageShown, area: QRectF, theme: Theme) -> None:
    width, height = shown.size
    room = area.adjusted(1.0, 1.0, -1.0, -_ROOM)
    scale = min(room.width() / width, room.height() / height)
    image = QRectF(0.0, 0.0, scale * width, scale * height)
    image.moveCenter(room.center())
    image.moveTop(room.top())
    painter.fillRect(image, QColor(theme.base))
    rows, columns = shown.cells.shape
    reached = QColor(theme.good)
    reached.setAlpha(70)
    for row, column in np.argwhere(shown.cells).tolist():
        cell = QRectF(
            image.left() + column * image.width() / columns,
            image.top() + row * image.height() / rows,
            image.width() / columns,
            image.height() / rows,
        )
        painter.fillRect(cell, reached)
    painter.setPen(QPen(QColor(theme.border), 1.0))
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.drawRect(image)
    painter.setPen(QPen(QColor(theme.text), 1.6))
    at = (shown.corners + 0.5) * scale + (image.left(), image.top())
    painter.drawPoints([QPointF(x, y) for x, y in at])
    painter.setPen(QColor(theme.muted))
    words = QRectF(area.left(), image.bottom() + 2.0, area.width(), _ROOM - 4.0)
    cut = painter.fontMetrics().elidedText(
        shown.title, Qt.TextElideMode.ElideRight, int(words.width())
    )
    painter.drawText(words, Qt.AlignmentFlag.AlignCenter, cut)
