"""The loupe: what is under the cursor, enlarged, every pixel a square."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPainterPath, QPen, QTransform

SIZE = 170.0
FACTOR = 4.0
LEAST_SCALE = 5.0
"""Widget pixels that a pixel of the picture has in the loupe at least."""

_MARGIN = 10.0


def loupe_size(bounds: QRectF) -> float:
    """Side or diameter of the loupe in a widget of this size."""
    return min(SIZE, 0.62 * min(bounds.width(), bounds.height()))


def paint_loupe(
    painter: QPainter,
    cursor: QPointF,
    bounds: QRectF,
    scale: float,
    paint: Callable[[QPainter, QTransform, float], None],
    *,
    rim: QColor,
    corner: bool,
) -> None:
    """Paint the neighbourhood of the cursor in a circle around it, or in a corner.

    Parameters
    ----------
    cursor : QPointF
        Place in the widget.
    bounds : QRectF
        The widget.
    scale : float
        Widget pixels per pixel of the picture without the loupe.
    paint : callable
        Paints the picture with a further transform, and is told the factor of it.
    corner : bool
        In the corner that is farthest from the cursor; else around the cursor.
    """
    factor = max(FACTOR, LEAST_SCALE / max(scale, 1e-6))
    size = loupe_size(bounds)
    centre = _corner(cursor, bounds, size) if corner else cursor
    frame = QRectF(centre.x() - 0.5 * size, centre.y() - 0.5 * size, size, size)
    path = QPainterPath()
    if corner:
        path.addRoundedRect(frame, 6.0, 6.0)
    else:
        path.addEllipse(frame)
    painter.save()
    painter.setClipPath(path)
    painter.fillRect(frame, QColor("black"))
    enlarge = (
        QTransform.fromTranslate(-cursor.x(), -cursor.y())
        * QTransform.fromScale(factor, factor)
        * QTransform.fromTranslate(centre.x(), centre.y())
    )
    paint(painter, enlarge, factor)
    _paint_cross(painter, centre, size)
    painter.restore()
    painter.setPen(QPen(rim, 2))
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.drawPath(path)


def _corner(cursor: QPointF, bounds: QRectF, size: float) -> QPointF:
    """Middle of the loupe in the corner away from the cursor."""
    left = cursor.x() > bounds.center().x()
    top = cursor.y() > bounds.center().y()
    reach = 0.5 * size + _MARGIN
    x = bounds.left() + reach if left else bounds.right() - reach
    y = bounds.top() + reach if top else bounds.bottom() - reach
    return QPointF(x, y)


def _paint_cross(painter: QPainter, centre: QPointF, size: float) -> None:
    """Cross-hairs with a gap, so that the pixel itself is seen."""
    for pen in (QPen(QColor(0, 0, 0, 150), 3), QPen(QColor(255, 255, 255, 210), 1)):
        painter.setPen(pen)
        for x, y in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            way = QPointF(x, y)
            painter.drawLine(centre + way * 4.0, centre + way * (0.32 * size))
