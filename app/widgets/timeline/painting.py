"""The parts of the timeline, painted from what the widget knows."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QFontMetricsF, QImage, QPainter, QPen, QPolygonF

from ..style.theme import Theme
from .lanes import Lane
from .scale import TimelineScale
from .strips import strip_pixels

RULER_HEIGHT = 24
LEAST_LANE, MOST_LANE = 13, 20
"""Heights between which lanes take what room there is."""
_LANE_GAP = 2
_LABELLED_BARS = 200


def time_text(frame: int, fps: float) -> str:
    """Time of a frame since the first, as a person reads it."""
    seconds = frame / fps if fps > 0 else 0.0
    minutes, rest = divmod(seconds, 60.0)
    return f"{int(minutes)}:{rest:04.1f} min" if minutes else f"{rest:.2f} s"


def paint_lanes(
    painter: QPainter,
    scale: TimelineScale,
    lanes: Sequence[Lane],
    lane_height: int,
    first_row: int,
    height: int,
    ratio: float,
    theme: Theme,
) -> None:
    """Paint the strips of the lanes that are to be seen.

    Parameters
    ----------
    painter : QPainter
    scale : TimelineScale
    lanes : sequence of Lane
    lane_height : int
    first_row : int
        Device-independent pixels that are scrolled away above.
    height : int
        Of the viewport.
    ratio : float
        Device pixels for an independent one.
    theme : Theme
    """
    if not scale.frame_count:
        return
    columns = max(1, round(scale.width * ratio))
    edges = scale.edges(columns)
    rows = max(4, round((lane_height - _LANE_GAP) * ratio))
    for index, lane in enumerate(lanes):
        top = RULER_HEIGHT + index * lane_height - first_row
        if top + lane_height < RULER_HEIGHT or top > height:
            continue
        pixels = strip_pixels(lane, edges, rows, theme)
        image = QImage(pixels.data, columns, rows, 4 * columns, QImage.Format.Format_RGBA8888)
        painter.drawImage(QRectF(scale.left, top, scale.width, lane_height - _LANE_GAP), image)
        if lane.kind == "bars":
            _paint_bar_labels(painter, scale, lane, top, lane_height, theme)


def _paint_bar_labels(
    painter: QPainter, scale: TimelineScale, lane: Lane, top: float, lane_height: int, theme: Theme
) -> None:
    metrics = QFontMetricsF(painter.font())
    painter.setPen(_readable_on(lane.colour, theme))
    visible = [s for s in lane.spans if s.label and s.last >= scale.first and s.first < scale.last]
    for span in visible[:_LABELLED_BARS]:
        left = max(scale.x_of(span.first), scale.left)
        right = min(scale.x_of(span.last + 1), scale.left + scale.width)
        if right - left < 28.0:
            continue
        text = metrics.elidedText(span.label, Qt.TextElideMode.ElideRight, right - left - 8.0)
        box = QRectF(left + 4.0, top, right - left - 8.0, lane_height - _LANE_GAP)
        painter.drawText(box, Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft, text)


def _readable_on(colour: str, theme: Theme) -> QColor:
    bright = QColor(colour).lightnessF() > 0.5
    dark, light = sorted((theme.base, theme.text), key=lambda c: QColor(c).lightnessF())
    return QColor(dark if bright else light)


def paint_names(
    painter: QPainter,
    lanes: Sequence[Lane],
    lane_height: int,
    first_row: int,
    width: int,
    height: int,
    theme: Theme,
    selected: Collection[str] = (),
) -> None:
    """Write each lane's name at the left, with its colour before it; selected ones stand out."""
    painter.fillRect(QRectF(0, RULER_HEIGHT, width - 2, height), QColor(theme.window))
    metrics = QFontMetricsF(painter.font())
    for index, lane in enumerate(lanes):
        top = RULER_HEIGHT + index * lane_height - first_row
        if top + lane_height < RULER_HEIGHT or top > height:
            continue
        if lane.id in selected:
            painter.fillRect(QRectF(0, top, width - 2, lane_height), QColor(theme.selection))
        painter.fillRect(QRectF(8, top + 3, 4, lane_height - _LANE_GAP - 6), QColor(lane.colour))
        painter.setPen(QColor(theme.text))
        text = metrics.elidedText(lane.name, Qt.TextElideMode.ElideRight, width - 26.0)
        box = QRectF(18, top, width - 24, lane_height - _LANE_GAP)
        painter.drawText(box, Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft, text)


def paint_ruler(
    painter: QPainter, scale: TimelineScale, fps: float, width: int, theme: Theme
) -> None:
    """Write frame numbers over the lanes, and the time where there is room."""
    painter.fillRect(QRectF(0, 0, width, RULER_HEIGHT), QColor(theme.raised))
    painter.setPen(QColor(theme.border))
    painter.drawLine(QPointF(0, RULER_HEIGHT - 0.5), QPointF(width, RULER_HEIGHT - 0.5))
    if not scale.frame_count:
        painter.setPen(QColor(theme.muted))
        flags = Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft
        painter.drawText(QRectF(8, 0, width, RULER_HEIGHT), flags, "no recording is open")
        return
    frames, _ = scale.ticks()
    for frame in frames:
        x = scale.x_of(frame)
        painter.setPen(QColor(theme.disabled))
        painter.drawLine(QPointF(x, RULER_HEIGHT - 7), QPointF(x, RULER_HEIGHT - 1))
        painter.setPen(QColor(theme.muted))
        if x + 40 < width:
            painter.drawText(QPointF(x + 4, RULER_HEIGHT - 8), str(frame))
    painter.setPen(QColor(theme.muted))
    box = QRectF(8, 0, scale.left - 16, RULER_HEIGHT)
    length = time_text(scale.frame_count, fps)
    flags = Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft
    painter.drawText(box, flags, f"{scale.frame_count} fr, {length}")


def paint_hint(painter: QPainter, text: str, left: float, size: QSize, theme: Theme) -> None:
    """Say in the room of the lanes why there are none."""
    painter.setPen(QColor(theme.muted))
    box = QRectF(left, RULER_HEIGHT, size.width() - left, size.height() - RULER_HEIGHT)
    painter.drawText(box, Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap, text)


def paint_selection(
    painter: QPainter,
    scale: TimelineScale,
    selection: range | None,
    height: int,
    theme: Theme,
) -> None:
    """Shade the selected frames."""
    if selection is None:
        return
    left = max(scale.x_of(selection.start), scale.left)
    right = min(scale.x_of(selection.stop), scale.left + scale.width)
    if right <= left:
        return
    colour = QColor(theme.accent)
    painter.fillRect(QRectF(left, 0, right - left, 4), colour)
    colour.setAlpha(46)
    painter.fillRect(QRectF(left, 0, right - left, height), colour)
    painter.setPen(QPen(QColor(theme.accent), 1.0))
    painter.drawLine(QPointF(left, 0), QPointF(left, height))
    painter.drawLine(QPointF(right, 0), QPointF(right, height))


def paint_playhead(
    painter: QPainter, scale: TimelineScale, frame: int, height: int, theme: Theme
) -> None:
    """Draw the playhead over the frame, with its number in the ruler."""
    left, right = scale.x_of(frame), scale.x_of(frame + 1)
    middle = (left + right) / 2
    if not scale.left <= middle <= scale.left + scale.width + 1:
        return
    colour = QColor(theme.playhead)
    if right - left > 3.0:
        wide = QColor(colour)
        wide.setAlpha(56)
        painter.fillRect(QRectF(left, RULER_HEIGHT, right - left, height), wide)
    painter.setPen(QPen(colour, 1.5))
    painter.drawLine(QPointF(middle, RULER_HEIGHT - 6), QPointF(middle, height))
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    text = str(frame)
    width = QFontMetricsF(painter.font()).horizontalAdvance(text) + 10.0
    low, high = scale.left, scale.left + scale.width - width
    box = QRectF(min(max(middle - width / 2, low), high), 2, width, RULER_HEIGHT - 9)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(colour)
    painter.drawRoundedRect(box, 3, 3)
    foot = RULER_HEIGHT - 7.5
    painter.drawPolygon(
        QPolygonF([QPointF(middle - 4, foot), QPointF(middle + 4, foot), QPointF(middle, foot + 6)])
    )
    painter.setPen(QColor(theme.window if theme.is_dark else theme.base))
    painter.drawText(box, Qt.AlignmentFlag.AlignCenter, text)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing, False)
