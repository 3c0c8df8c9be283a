"""Paint clicks, predictions, epipolar curves and residuals; sizes in the widget's pixels."""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot, isfinite

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import (
    QColor,
    QFont,
    QFontMetricsF,
    QPainter,
    QPainterPath,
    QPen,
    QPolygonF,
    QTransform,
)

from ..style.colours import LIMB_COLOURS, OLD
from .click_marks import ClickMark, ClickMarks, CurveMark, PredictionMark
from .overlays import stroke

DOT = 4.5
RING = 10.0
_CROSS = 6.0
_DIAMOND = 7.0
_DARK = QColor(0, 0, 0, 190)
_WHITE = QColor(255, 255, 255)
_WARNING = QColor("#F0E442")
_LEAST_RESIDUAL = 3.0  # widget pixels below which a residual is hidden by its click


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

    def at(mark: ClickMark | PredictionMark) -> QPointF:
        return to_widget.map(QPointF(mark.x, mark.y))

    clicks = [(one, at(one)) for one in marks.clicks if "clicks" in shown]
    predictions = [(one, at(one)) for one in marks.predictions if "predictions" in shown]
    curves = [
        (one, to_widget.map(QPolygonF([QPointF(x, y) for x, y in one.points.tolist()])))
        for one in marks.curves
        if "epipolar" in shown
    ]
    if "fit" in shown:
        _paint_model(painter, marks, to_widget)
    for curve, line in curves:
        path, colour = QPainterPath(), QColor(curve.colour).lighter(125)
        path.addPolygon(line)
        stroke(painter, path, QPen(QColor(0, 0, 0, 120), 3.2), QPen(colour, 1.4))
    if "residuals" in shown:
        _paint_residuals(painter, marks, to_widget)
    for mark, place in predictions:
        painter.setOpacity(mark.opacity)
        _paint_prediction(painter, mark, place, hypot(to_widget.m11(), to_widget.m12()))
        painter.setOpacity(1.0)
    for click, place in sorted(clicks, key=_importance):
        _paint_ring(painter, click, place)
        _paint_dot(painter, click, place)
    names = _Names(painter, bounds, [place for _, place in clicks])
    _write_names(names, clicks, predictions, curves)


def _write_names(
    names: _Names,
    clicks: Sequence[tuple[ClickMark, QPointF]],
    predictions: Sequence[tuple[PredictionMark, QPointF]],
    curves: Sequence[tuple[CurveMark, QPolygonF]],
) -> None:
    for click, place in sorted(clicks, key=_importance, reverse=True):
        whole = click.chosen or click.at_hand
        text = click.label if whole else short_label(click.label)
        names.write(f"{text}?" if click.doubted else text, place, whole=whole)
    for mark, place in predictions:
        if mark.chosen:  # how far its click is from where the other views have it
            words = f"{mark.error_px:.1f} px" if isfinite(mark.error_px) else "predicted"
            names.write(words, place, whole=False)
    window = names.bounds.adjusted(4, 8, -30, -12)
    for curve, line in curves:  # at the far end inside the picture: whose click it comes from
        inside = [line.at(i) for i in range(line.size()) if window.contains(line.at(i))]
        if inside:
            names.write(curve.from_view, inside[-1], whole=False)


def _importance(one: tuple[ClickMark, QPointF]) -> tuple[bool, bool]:
    return one[0].at_hand, one[0].chosen


def short_label(label: str) -> str:
    """``L elbow`` for ``left elbow``; names without a side stay."""
    side, _, rest = label.partition(" ")
    return f"{side[0].upper()} {rest}" if side in {"left", "right"} and rest else label


def _paint_dot(painter: QPainter, mark: ClickMark, place: QPointF) -> None:
    """Filled: seen; hollow: guessed; dashed: its author doubts it. A dark rim sets it off.

    A proposal that was accepted stays a diamond.
    """
    colour, rim = QColor(mark.colour), QPen(_DARK, 4.6)
    if not mark.guessed and not mark.doubted:
        shape = _diamond(place, DOT + 1.5) if mark.accepted else _circle(place, DOT)
        stroke(painter, shape, rim, QPen(_WHITE, 1.6), fill=colour)
        return
    pen = QPen(colour, 2.4)
    if mark.doubted:
        pen.setDashPattern([1.3, 1.1])
        pen.setCapStyle(Qt.PenCapStyle.FlatCap)
    stroke(painter, _circle(place, DOT + 1.0), rim, QPen(_WHITE, 3.4), pen)
    if not mark.guessed:
        painter.fillPath(_circle(place, 2.4), colour)


def _paint_ring(painter: QPainter, mark: ClickMark, place: QPointF) -> None:
    """A ring: keys act on it; four arrows: Alt+arrows move it; yellow: perhaps an outlier."""
    if mark.outlier:
        dotted = QPen(_WARNING, 2.4, Qt.PenStyle.DotLine)
        stroke(painter, _circle(place, RING + 3.0), QPen(_DARK, 4.4), dotted)
    if mark.at_hand:
        stroke(painter, _circle(place, RING), QPen(_DARK, 3.4), QPen(_WHITE, 1.4))
    if mark.at_hand and mark.held:
        arrows = QPainterPath()
        for way in (QPointF(1, 0), QPointF(0, 1), QPointF(-1, 0), QPointF(0, -1)):
            base, aside = place + way * (RING + 2.5), QPointF(-way.y(), way.x()) * 4.5
            arrows.addPolygon(QPolygonF([base + way * 6.0, base + aside, base - aside]))
            arrows.closeSubpath()
        stroke(painter, arrows, QPen(_DARK, 1.0), fill=_WHITE)


def paint_crosshair(painter: QPainter, place: QPointF, colour: str) -> None:
    """Four lines towards the place at which a key places a landmark; the place stays free."""
    lines = QPainterPath()
    for way in (QPointF(1, 0), QPointF(0, 1), QPointF(-1, 0), QPointF(0, -1)):
        lines.moveTo(place + way * RING)
        lines.lineTo(place + way * 4.0 * RING)
    stroke(painter, lines, QPen(_DARK, 4.2), QPen(_WHITE, 2.8), QPen(QColor(colour), 1.6))


def _circle(place: QPointF, radius: float) -> QPainterPath:
    path = QPainterPath()
    path.addEllipse(place, radius, radius)
    return path


def _diamond(place: QPointF, size: float) -> QPainterPath:
    path = QPainterPath()
    corners = [QPointF(0, -size), QPointF(size, 0), QPointF(0, size), QPointF(-size, 0)]
    path.addPolygon(QPolygonF([place + corner for corner in corners]))
    path.closeSubpath()
    return path


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
        said.append(f"outside: {', '.join(map(short_label, marks.outside))}")
    if marks is not None and "predictions" in shown:
        uncertain = sum(mark.proposed and not mark.certain for mark in marks.predictions)
        if uncertain:
            said.append(f"{uncertain} doubtful")
        if marks.proposed_outside:
            names = ", ".join(map(short_label, marks.proposed_outside))
            said.append(f"predicted as outside: {names}")
    if marks is not None and marks.model and marks.model_is_old and "fit" in shown:
        old.append("model")
    if reference_is_old and "reference" in shown:
        old.append("reference")
    if old:
        said.append(f"{' and '.join(old)} from before the last click")
    if not said:
        return
    text = "; ".join(said)
    font = _small_font(painter)
    metrics = QFontMetricsF(font)
    width = min(metrics.horizontalAdvance(text) + 10.0, bounds.width() - 12.0)
    corner = (bounds.left() + 6.0, bounds.bottom() - metrics.height() - 8.0)
    box = QRectF(*corner, width, metrics.height() + 2.0)
    words = metrics.elidedText(text, Qt.TextElideMode.ElideRight, width - 8.0)
    _write(painter, box, words, font, 150)


class _Names:
    """Writes beside points, where no other name or point stands; dark below to be read."""

    def __init__(self, painter: QPainter, bounds: QRectF, dots: Sequence[QPointF]) -> None:
        self._painter, self.bounds, self._dots = painter, bounds, dots
        reach = QPointF(DOT, DOT)
        self._taken = [QRectF(dot - reach, dot + reach) for dot in dots]

    def write(self, text: str, place: QPointF, *, whole: bool) -> None:
        """Write a name; one that is not `whole` only where there is room for it."""
        painter = self._painter
        font = _small_font(painter, bold=whole)
        metrics = QFontMetricsF(font)
        size = (metrics.horizontalAdvance(text) + 6.0, metrics.height())
        boxes = _boxes(place, *size)
        inside = (box for box in boxes if self.bounds.contains(box))
        free = (box for box in inside if not any(map(box.intersects, self._taken)))
        own = next((box for box in free if self._is_own(box, place)), None)
        if own is None and not whole:
            return  # two names over each other could not be read; the colour tells
        box = own or boxes[0]
        self._taken.append(box)
        _write(painter, box, text, font, 150 if whole else 110)

    def _is_own(self, box: QRectF, place: QPointF) -> bool:
        """Whether every other dot is clearly farther from a name than its own."""
        others = (dot for dot in self._dots if dot != place)
        return all(_distance(box, dot) > 2.0 * _distance(box, place) for dot in others)


def _distance(box: QRectF, place: QPointF) -> float:
    x, y = place.x(), place.y()
    away = max(box.left() - x, x - box.right(), 0.0), max(box.top() - y, y - box.bottom(), 0.0)
    return hypot(*away)


def _boxes(place: QPointF, width: float, height: float) -> list[QRectF]:
    """Boxes to the right and left of a point, and above and below it."""
    x, y, gap, far = place.x(), place.y(), DOT + 5.0, RING + 6.0
    corners = (
        *((x + gap, y - 0.5 * height), (x - gap - width, y - 0.5 * height)),
        *((x - 0.5 * width, y - far - height), (x - 0.5 * width, y + far)),
    )
    return [QRectF(*corner, width, height) for corner in corners]


def _small_font(painter: QPainter, *, bold: bool = False) -> QFont:
    font = QFont(painter.font())
    font.setPointSizeF(max(7.0, 0.9 * font.pointSizeF()))
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


def _paint_prediction(
    painter: QPainter, mark: PredictionMark, place: QPointF, scale: float
) -> None:
    """Hollow diamonds: proposed for this frame; crosses: from elsewhere. No click is either.

    The middle of a diamond stays free, so that the picture is seen where the landmark would be.
    Dotted: guessed. Dashed circle: the standard deviation, if that is too large to be accepted.
    """
    size = (_DIAMOND if mark.proposed else _CROSS) + (2.0 if mark.chosen else 0.0)
    style = Qt.PenStyle.DotLine if mark.guessed else Qt.PenStyle.SolidLine
    if mark.proposed:
        pens = QPen(_DARK, 4.2), QPen(_WHITE, 2.8), QPen(QColor(mark.colour), 1.9, style)
        stroke(painter, _diamond(place, size), *pens)
    else:
        cross, flat = QPainterPath(), Qt.PenCapStyle.FlatCap
        for way in (QPointF(size, size), QPointF(size, -size)):
            cross.moveTo(place - way)
            cross.lineTo(place + way)
        colour = QPen(QColor(mark.colour).lighter(120), 1.9, style, flat)
        stroke(painter, cross, QPen(_DARK, 4.0, Qt.PenStyle.SolidLine, flat), colour)
    if not mark.certain and isfinite(mark.spread_px):
        dashed = QPen(QColor(mark.colour).lighter(130), 1.6, Qt.PenStyle.DashLine)
        circle = _circle(place, max(mark.spread_px * scale, size + 3.0))
        stroke(painter, circle, QPen(_DARK, 3.0), dashed)


def _paint_residuals(painter: QPainter, marks: ClickMarks, to_widget: QTransform) -> None:
    """Lines from clicks to the model, with a small square on the model."""
    for mark in marks.residuals:
        start, end = to_widget.map(QPointF(*mark.start)), to_widget.map(QPointF(*mark.end))
        if hypot(end.x() - start.x(), end.y() - start.y()) < _LEAST_RESIDUAL:
            continue
        line, square = QPainterPath(start), QPainterPath()
        line.lineTo(end)
        square.addRect(QRectF(end.x() - 2.5, end.y() - 2.5, 5.0, 5.0))
        colour = QColor(mark.colour)
        stroke(painter, line, QPen(_DARK, 4.0), QPen(_WHITE, 2.6), QPen(colour, 1.6))
        stroke(painter, square, QPen(_DARK, 1.0), fill=_WHITE)


def _paint_model(painter: QPainter, marks: ClickMarks, to_widget: QTransform) -> None:
    """Outline of the fitted model: dashed, so that it differs from a run's; dotted while old."""
    dashes = Qt.PenStyle.DotLine if marks.model_is_old else Qt.PenStyle.DashLine
    for mark in marks.model:
        painter.setOpacity(mark.opacity * (OLD if marks.model_is_old else 1.0))
        lines = (QColor(0, 0, 0, 130), 2.8), (QColor(LIMB_COLOURS[mark.limb]), 1.5)
        pens = (QPen(colour, width, dashes, Qt.PenCapStyle.FlatCap) for colour, width in lines)
        stroke(painter, to_widget.map(mark.path), *pens)
    painter.setOpacity(1.0)
