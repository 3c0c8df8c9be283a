"""Paint clicks, predictions, epipolar curves and residuals; sizes in the widget's pixels."""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot, isfinite

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPen, QPolygonF, QTransform

from ..style.colours import LIMB_COLOURS, OLD
from .click_marks import ClickMark, ClickMarks, CurveMark, PredictionMark, ResidualMark

DOT = 4.5
RING = 10.0
_CROSS = 6.0
_DIAMOND = 7.0
_DARK = QColor(0, 0, 0, 190)
_WHITE = QColor(255, 255, 255)
_WARNING = QColor("#F0E442")
_LEAST_RESIDUAL = 3.0
"""Widget pixels below which a residual is hidden by its click."""


def paint_marks(
    painter: QPainter,
    marks: ClickMarks,
    to_widget: QTransform,
    shown: frozenset[str],
    bounds: QRectF,
) -> None:
    """Paint what is switched on; `to_widget` leads from raw pixels to the painter's coordinates.

    Names stay inside `bounds`, which is what is seen, in the painter's coordinates.
    """
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.setBrush(Qt.BrushStyle.NoBrush)
    if "fit" in shown:
        _paint_model(painter, marks, to_widget)
    if "epipolar" in shown:
        _paint_curves(painter, marks.curves, to_widget)
    if "residuals" in shown:
        _paint_residuals(painter, marks.residuals, to_widget)
    if "predictions" in shown:
        _paint_predictions(painter, marks.predictions, to_widget)
    names = _Names(painter, bounds)
    if "clicks" in shown:
        _paint_clicks(painter, marks.clicks, to_widget)
        names.keep_free([to_widget.map(QPointF(mark.x, mark.y)) for mark in marks.clicks])
        _name_clicks(names, marks.clicks, to_widget)
    if "predictions" in shown:
        _name_predictions(names, marks.predictions, to_widget)
    if "epipolar" in shown:
        _name_curves(names, marks.curves, to_widget, bounds)


def short_label(label: str) -> str:
    """``L elbow`` for ``left elbow``; names without a side stay."""
    side, _, rest = label.partition(" ")
    return f"{side[0].upper()} {rest}" if side in {"left", "right"} and rest else label


def _paint_clicks(painter: QPainter, clicks: Sequence[ClickMark], to_widget: QTransform) -> None:
    for mark in sorted(clicks, key=_importance):
        place = to_widget.map(QPointF(mark.x, mark.y))
        if mark.at_hand or mark.outlier:
            _paint_ring(painter, mark, place)
        _paint_dot(painter, mark, place)


def _importance(mark: ClickMark) -> tuple[bool, bool]:
    return mark.at_hand, mark.chosen


def _name_clicks(names: _Names, clicks: Sequence[ClickMark], to_widget: QTransform) -> None:
    for mark in sorted(clicks, key=_importance, reverse=True):
        whole = mark.chosen or mark.at_hand
        text = mark.label if whole else short_label(mark.label)
        place = to_widget.map(QPointF(mark.x, mark.y))
        names.write(f"{text}?" if mark.doubted else text, place, whole=whole)


def _name_predictions(
    names: _Names, predictions: Sequence[PredictionMark], to_widget: QTransform
) -> None:
    """Say how far the chosen landmark's click is from where the other views have it."""
    for mark in predictions:
        if mark.chosen:
            words = f"{mark.error_px:.1f} px" if isfinite(mark.error_px) else "predicted"
            names.write(words, to_widget.map(QPointF(mark.x, mark.y)), whole=False)


def _name_curves(
    names: _Names, curves: Sequence[CurveMark], to_widget: QTransform, bounds: QRectF
) -> None:
    """Say at each curve's far end, inside the picture, whose click it comes from."""
    window = bounds.adjusted(4, 8, -30, -12)
    for curve in curves:
        line = to_widget.map(QPolygonF([QPointF(x, y) for x, y in curve.points.tolist()]))
        inside = [line.at(i) for i in range(line.size()) if window.contains(line.at(i))]
        if inside:
            names.write(curve.from_view, inside[-1], whole=False)


def _paint_dot(painter: QPainter, mark: ClickMark, place: QPointF) -> None:
    """Filled: seen; hollow: guessed; dashed: its author doubts it. A dark rim sets it off.

    A proposal that was accepted stays a diamond.
    """
    colour = QColor(mark.colour)
    if mark.accepted and not mark.guessed and not mark.doubted:
        painter.setBrush(colour)
        _paint_diamond(painter, place, DOT + 1.5, QPen(_DARK, 4.6), QPen(_WHITE, 1.6))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        return
    if not mark.guessed and not mark.doubted:
        _circle(painter, place, DOT, QPen(_DARK, 4.6))
        painter.setBrush(colour)
        _circle(painter, place, DOT, QPen(_WHITE, 1.6))
        return
    pen = QPen(colour, 2.4)
    if mark.doubted:
        pen.setDashPattern([1.3, 1.1])
        pen.setCapStyle(Qt.PenCapStyle.FlatCap)
    _circle(painter, place, DOT + 1.0, QPen(_DARK, 4.6), QPen(_WHITE, 3.4), pen)
    if not mark.guessed:
        painter.setBrush(colour)
        _circle(painter, place, 2.4, QPen(Qt.PenStyle.NoPen))


def _paint_ring(painter: QPainter, mark: ClickMark, place: QPointF) -> None:
    """A ring: keys act on it; four arrows: arrow keys move it; yellow: perhaps an outlier."""
    if mark.outlier:
        dotted = QPen(_WARNING, 2.4, Qt.PenStyle.DotLine)
        _circle(painter, place, RING + 3.0, QPen(_DARK, 4.4), dotted)
    if mark.at_hand:
        _circle(painter, place, RING, QPen(_DARK, 3.4), QPen(_WHITE, 1.4))
    if mark.at_hand and mark.held:
        painter.setPen(QPen(_DARK, 1.0))
        painter.setBrush(_WHITE)
        for x, y in ((1, 0), (0, 1), (-1, 0), (0, -1)):
            painter.drawPolygon(_arrow(place, x, y, RING + 2.5))
        painter.setBrush(Qt.BrushStyle.NoBrush)


def _circle(painter: QPainter, place: QPointF, radius: float, *pens: QPen) -> None:
    """Draw a circle with pens over each other, filled as the painter's brush says."""
    for pen in pens:
        painter.setPen(pen)
        painter.drawEllipse(place, radius, radius)
    painter.setBrush(Qt.BrushStyle.NoBrush)


def _arrow(place: QPointF, x: float, y: float, start: float) -> QPolygonF:
    tip = place + QPointF(x, y) * (start + 6.0)
    base, aside = place + QPointF(x, y) * start, QPointF(-y, x) * 4.5
    return QPolygonF([tip, base + aside, base - aside])


def paint_notes(
    painter: QPainter,
    marks: ClickMarks | None,
    shown: frozenset[str],
    bounds: QRectF,
    *,
    reference_is_old: bool = False,
) -> None:
    """Say in the lower left corner what is not in the picture, and what that is drawn is old."""
    said, old = [], []
    if marks is not None and marks.outside and "clicks" in shown:
        said.append(f"outside: {', '.join(short_label(label) for label in marks.outside)}")
    if marks is not None and "predictions" in shown:
        said += _notes_on_proposals(marks)
    if marks is not None and marks.model and marks.model_is_old and "fit" in shown:
        old.append("model")
    if reference_is_old and "reference" in shown:
        old.append("reference")
    if old:
        said.append(f"{' and '.join(old)} from before the last click")
    if not said:
        return
    text = "; ".join(said)
    font = _small_font(painter, 0.9)
    metrics = QFontMetricsF(font)
    width = min(metrics.horizontalAdvance(text) + 10.0, bounds.width() - 12.0)
    corner = (bounds.left() + 6.0, bounds.bottom() - metrics.height() - 8.0)
    box = QRectF(*corner, width, metrics.height() + 2.0)
    words = metrics.elidedText(text, Qt.TextElideMode.ElideRight, width - 8.0)
    _write(painter, box, words, font, 150)


def _notes_on_proposals(marks: ClickMarks) -> list[str]:
    """What accepting leaves open or marks as outside."""
    uncertain = sum(mark.proposed and not mark.certain for mark in marks.predictions)
    said = [f"{uncertain} too uncertain to accept"] if uncertain else []
    if marks.proposed_outside:
        names = ", ".join(short_label(label) for label in marks.proposed_outside)
        said.append(f"proposed as outside: {names}")
    return said


class _Names:
    """Writes beside points, where no other name stands; dark below so that it can be read."""

    def __init__(self, painter: QPainter, bounds: QRectF) -> None:
        self._painter, self._bounds = painter, bounds
        self._taken: list[QRectF] = []

    def keep_free(self, dots: Sequence[QPointF]) -> None:
        """Write over none of these dots."""
        reach = QPointF(DOT, DOT)
        self._taken += [QRectF(dot - reach, dot + reach) for dot in dots]

    def write(self, text: str, place: QPointF, *, whole: bool) -> None:
        """Write a name; one that is not `whole` only where there is room for it."""
        painter = self._painter
        font = _small_font(painter, 0.9, bold=whole)
        metrics = QFontMetricsF(font)
        size = (metrics.horizontalAdvance(text) + 6.0, metrics.height())
        boxes = _around(place, *size)
        free = [box for box in boxes if self._bounds.contains(box) and not self._meets(box)]
        if not free and not whole:
            return  # two names over each other could not be read; the colour tells
        box = free[0] if free else boxes[0]
        self._taken.append(box)
        _write(painter, box, text, font, 150 if whole else 110)

    def _meets(self, box: QRectF) -> bool:
        return any(box.intersects(other) for other in self._taken)


def _around(place: QPointF, width: float, height: float) -> list[QRectF]:
    """Boxes beside a point, the best first."""
    gap = DOT + 5.0
    right, left = place.x() + gap, place.x() - gap - width
    rows = (place.y() - 0.5 * height, place.y() - height - 2.0, place.y() + 2.0)
    return [QRectF(x, y, width, height) for y in rows for x in (right, left)]


def _small_font(painter: QPainter, factor: float, *, bold: bool = False) -> QFont:
    font = QFont(painter.font())
    font.setPointSizeF(max(7.0, factor * font.pointSizeF()))
    font.setBold(bold)
    return font


def _write(painter: QPainter, box: QRectF, text: str, font: QFont, darkness: int) -> None:
    painter.save()
    painter.setFont(font)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(QColor(0, 0, 0, darkness))
    painter.drawRoundedRect(box, 3.0, 3.0)
    painter.setPen(_WHITE)
    painter.drawText(box, Qt.AlignmentFlag.AlignCenter, text)
    painter.restore()


def _paint_predictions(
    painter: QPainter, predictions: Sequence[PredictionMark], to_widget: QTransform
) -> None:
    """Hollow diamonds: proposed for this frame; crosses: from elsewhere. No click is either."""
    for mark in predictions:
        place = to_widget.map(QPointF(mark.x, mark.y))
        if mark.proposed:
            _paint_proposal(painter, mark, place, to_widget)
            continue
        size = _CROSS + (2.0 if mark.chosen else 0.0)
        painter.setOpacity(mark.opacity)
        colour = QPen(QColor(mark.colour).lighter(120), 1.9)
        if mark.guessed:
            colour.setStyle(Qt.PenStyle.DotLine)
        for pen in (QPen(_DARK, 4.0), colour):
            pen.setCapStyle(Qt.PenCapStyle.FlatCap)
            painter.setPen(pen)
            painter.drawLine(place + QPointF(-size, -size), place + QPointF(size, size))
            painter.drawLine(place + QPointF(-size, size), place + QPointF(size, -size))
        _paint_spread(painter, mark, place, size, to_widget)
        painter.setOpacity(1.0)


def _paint_proposal(
    painter: QPainter, mark: PredictionMark, place: QPointF, to_widget: QTransform
) -> None:
    """The middle stays free, so that the picture is seen where the landmark would be.

    Dotted: guessed. The less certain the fainter.
    """
    size = _DIAMOND + (2.0 if mark.chosen else 0.0)
    colour = QPen(QColor(mark.colour), 1.9)
    if mark.guessed:
        colour.setStyle(Qt.PenStyle.DotLine)
    painter.setOpacity(mark.opacity)
    _paint_diamond(painter, place, size, QPen(_DARK, 4.2), QPen(_WHITE, 2.8), colour)
    _paint_spread(painter, mark, place, size, to_widget)
    painter.setOpacity(1.0)


def _paint_spread(
    painter: QPainter, mark: PredictionMark, place: QPointF, size: float, to_widget: QTransform
) -> None:
    """Dashed circle of the standard deviation, if that is too large to be accepted."""
    if not mark.certain and isfinite(mark.spread_px):
        radius = max(mark.spread_px * hypot(to_widget.m11(), to_widget.m12()), size + 3.0)
        dashed = QPen(QColor(mark.colour).lighter(130), 1.6, Qt.PenStyle.DashLine)
        _circle(painter, place, radius, QPen(_DARK, 3.0), dashed)


def _paint_diamond(painter: QPainter, place: QPointF, size: float, *pens: QPen) -> None:
    corners = [QPointF(0, -size), QPointF(size, 0), QPointF(0, size), QPointF(-size, 0)]
    diamond = QPolygonF([place + corner for corner in corners])
    for pen in pens:
        painter.setPen(pen)
        painter.drawPolygon(diamond)


def _paint_curves(painter: QPainter, curves: Sequence[CurveMark], to_widget: QTransform) -> None:
    for curve in curves:
        line = to_widget.map(QPolygonF([QPointF(x, y) for x, y in curve.points.tolist()]))
        for colour, width in (
            (QColor(0, 0, 0, 120), 3.2),
            (QColor(curve.colour).lighter(125), 1.4),
        ):
            painter.setPen(QPen(colour, width))
            painter.drawPolyline(line)


def _paint_residuals(
    painter: QPainter, residuals: Sequence[ResidualMark], to_widget: QTransform
) -> None:
    """Lines from clicks to the model, with a small square on the model."""
    for mark in residuals:
        start, end = to_widget.map(QPointF(*mark.start)), to_widget.map(QPointF(*mark.end))
        if hypot(end.x() - start.x(), end.y() - start.y()) < _LEAST_RESIDUAL:
            continue
        for pen in (QPen(_DARK, 4.0), QPen(_WHITE, 2.6), QPen(QColor(mark.colour), 1.6)):
            painter.setPen(pen)
            painter.drawLine(start, end)
        painter.setPen(QPen(_DARK, 1.0))
        painter.setBrush(_WHITE)
        painter.drawRect(QRectF(end.x() - 2.5, end.y() - 2.5, 5.0, 5.0))
        painter.setBrush(Qt.BrushStyle.NoBrush)


def _paint_model(painter: QPainter, marks: ClickMarks, to_widget: QTransform) -> None:
    """Outline of the fitted model: dashed, so that it differs from a run's; dotted while old."""
    dashes = Qt.PenStyle.DotLine if marks.model_is_old else Qt.PenStyle.DashLine
    for mark in marks.model:
        line = to_widget.map(mark.path)
        painter.setOpacity(mark.opacity * (OLD if marks.model_is_old else 1.0))
        for colour, width in ((QColor(0, 0, 0, 130), 2.8), (QColor(LIMB_COLOURS[mark.limb]), 1.5)):
            painter.setPen(QPen(colour, width, dashes, Qt.PenCapStyle.FlatCap))
            painter.drawPath(line)
    painter.setOpacity(1.0)
