"""Lettering over the scene: names, north, axes, and the legend of the points' colours."""

from collections.abc import Iterator, Mapping

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPen

from stereotrack_core.arrays import FloatArray

from ..style.theme import Theme
from .content import NORTH_TIP, PointLegend, SceneContent
from .orbit import Orbit

_AXES = (("x", "#e0605a"), ("y", "#4fa85a"), ("z", "#4d97e8"))
"""Axes of the world and their colours: x is east, y north, z up."""
_AXIS_LENGTH = 26.0
_MARGIN, _GAP, _ROW, _SWATCH = 6.0, 6.0, 18.0, 9.0


def paint_lettering(
    painter: QPainter,
    content: SceneContent,
    layers: Mapping[str, bool],
    orbit: Orbit,
    area: QRectF,
    theme: Theme,
) -> None:
    """Write what belongs to the layers that are shown."""
    if layers["floor"]:
        _paint_axes(painter, orbit, area)
    words = list(_words(content, layers))
    places = orbit.project(np.array([at for _, at, _ in words]), area.width(), area.height())
    written: list[QRectF] = []
    for (text, _, colour), (x, y) in zip(words, places, strict=True):
        if not np.isfinite([x, y]).all():  # it is behind the eye
            continue
        width = painter.fontMetrics().horizontalAdvance(text)
        box = QRectF(x - 0.5 * width - 2.0, y - 10.0, width + 4.0, 20.0)
        if area.contains(box) and not any(map(box.intersects, written)):
            written.append(box)
            _write(painter, text, box, getattr(theme, colour), theme.scene_bottom)
    if layers["cloud"] and len(content.cloud_points) and content.point_legend is not None:
        _paint_legend(painter, content.point_legend, area, theme)


def _words(
    content: SceneContent, layers: Mapping[str, bool]
) -> Iterator[tuple[str, FloatArray, str]]:
    """Texts, where (3,) they stand in the world, and which of the theme's colours they have."""
    if layers["cameras"]:
        yield from ((one.name, one.position_world, "text") for one in content.cameras)
    if layers["floor"]:
        yield "N", np.array([0.0, NORTH_TIP + 0.15, content.floor_z]), "text"


def _write(painter: QPainter, text: str, box: QRectF, colour: str, shadow: str) -> None:
    painter.setPen(QColor(shadow))
    painter.drawText(box.translated(1.0, 1.0), Qt.AlignmentFlag.AlignCenter, text)
    painter.setPen(QColor(colour))
    painter.drawText(box, Qt.AlignmentFlag.AlignCenter, text)


def _paint_axes(painter: QPainter, orbit: Orbit, area: QRectF) -> None:
    middle = area.bottomRight() - QPointF(44.0, 42.0)
    painter.save()
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    flat = np.column_stack([orbit.right, -orbit.up])
    for axis in np.argsort(orbit.toward_eye):  # the nearest last
        name, colour = _AXES[axis]
        end = QPointF(*(_AXIS_LENGTH * flat[axis]))
        painter.setPen(QPen(QColor(colour), 2.0))
        painter.drawLine(middle, middle + end)
        box = QRectF(0.0, 0.0, 16.0, 16.0)
        box.moveCenter(middle + end * (1.0 + 9.0 / _AXIS_LENGTH))
        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, name)
    painter.restore()


def _paint_legend(painter: QPainter, legend: PointLegend, area: QRectF, theme: Theme) -> None:
    """Say at the top left what the colours of the points mean, in as many rows as it takes."""
    metrics = painter.fontMetrics()
    widest = area.width() - 2.0 * _MARGIN
    places: list[tuple[QPointF, float, str, tuple[int, int, int] | None]] = []
    x = y = right = 0.0
    for text, colour in ((legend.title, None), *legend.entries):
        swatch = 0.0 if colour is None else _SWATCH + 0.7 * _GAP
        width = swatch + metrics.horizontalAdvance(text)
        if x and x + width > widest - 2.0 * _GAP:
            x, y = 0.0, y + _ROW
        places.append((QPointF(x, y), swatch, text, colour))
        x += width + 2.0 * _GAP
        right = max(right, x)
    corner = area.topLeft() + QPointF(_MARGIN, _MARGIN)
    painter.save()
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.setPen(Qt.PenStyle.NoPen)
    paper = QColor(theme.base)
    paper.setAlpha(215)
    painter.setBrush(paper)
    painter.drawRoundedRect(QRectF(corner.x(), corner.y(), right, y + _ROW + 4.0), 4.0, 4.0)
    for place, swatch, text, colour in places:
        at = corner + place + QPointF(_GAP, 2.0)
        if colour is not None:
            dot = QRectF(at.x(), at.y() + 0.5 * (_ROW - _SWATCH), _SWATCH, _SWATCH)
            painter.fillRect(dot, QColor(*colour))
        painter.setPen(QColor(theme.text))
        row = QRectF(at.x() + swatch, at.y(), widest, _ROW)
        painter.drawText(row, Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft, text)
    painter.restore()
