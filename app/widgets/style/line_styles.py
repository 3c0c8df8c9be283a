"""Line styles by which runs are told apart, the same in plots, views, lists and the scene."""

from __future__ import annotations

from typing import Literal, TypeAlias

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPen, QPixmap

from .building import shortened

LineStyle: TypeAlias = Literal["solid", "dash", "dot", "dashdot", "reference"]

PEN_STYLES: dict[LineStyle, Qt.PenStyle] = {
    "solid": Qt.PenStyle.SolidLine,
    "dash": Qt.PenStyle.DashLine,
    "dot": Qt.PenStyle.DotLine,
    "dashdot": Qt.PenStyle.DashDotLine,
    "reference": Qt.PenStyle.DashDotDotLine,
}
"""No run has the style of the reference."""

_LINE = 26.0
_ROW = 17.0
_GAP = 6.0
_MOST_LETTERS = 34


def line_pixmap(style: LineStyle, colour: QColor, ratio: float) -> QPixmap:
    """A piece of line of that style, 28 x 14 pixels."""
    pixmap = QPixmap(round(28 * ratio), round(14 * ratio))
    pixmap.setDevicePixelRatio(ratio)
    pixmap.fill(Qt.GlobalColor.transparent)
    painter = QPainter(pixmap)
    painter.setPen(QPen(colour, 1.6, PEN_STYLES[style]))
    painter.drawLine(2, 7, 26, 7)
    painter.end()
    return pixmap


def paint_runs_legend(
    painter: QPainter, runs: tuple[tuple[str, LineStyle], ...], area: QRectF
) -> None:
    """Say at the bottom left of `area` which line belongs to which run; nothing for one run."""
    if len(runs) < 2:
        return
    metrics = painter.fontMetrics()
    names = [shortened(name, _MOST_LETTERS) for name, _ in runs]
    width = _LINE + 3 * _GAP + max(metrics.horizontalAdvance(name) for name in names)
    box = QRectF(
        area.left() + _GAP, area.bottom() - _GAP - _ROW * len(runs) - 4, width, _ROW * len(runs) + 4
    )
    painter.save()
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(QColor(0, 0, 0, 165))
    painter.drawRoundedRect(box, 4.0, 4.0)
    for row, (name, (_, style)) in enumerate(zip(names, runs, strict=True)):
        line = QRectF(box.left() + _GAP, box.top() + 2 + row * _ROW, _LINE, _ROW)
        painter.setPen(QPen(QColor("white"), 1.8, PEN_STYLES[style]))
        middle = line.center().y()
        painter.drawLine(QPointF(line.left(), middle), QPointF(line.right(), middle))
        words = QRectF(line.right() + _GAP, line.top(), width, _ROW)
        painter.drawText(words, Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft, name)
    painter.restore()
