"""The parts of the timeline, painted from what the widget knows."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QFontMetricsF, QImage, QPainter, QPen, QPolygonF

from ..style.theme import current_theme
from .lanes import Lane
from .scale import TimelineScale
from .strips import strip_pixels

RULER_HEIGHT = 24
LEAST_LANE, MOST_LANE = 13, 20
"""Heights between which lanes take what room there is."""
_LANE_GAP = 2
_LABELLED_BARS = 200
_LEFT = Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft


def time_text(frame: int, fps: float) -> str:
    """Time of a frame since the first, as a person reads it."""
    seconds = frame / fps if fps > 0 else 0.0
    minutes, rest = divmod(seconds, 60.0)
    return f"{int(minutes)}:{rest:04.1f} min" if minutes else f"{rest:.2f} s"


class TimelinePainter:
    """Paints on a viewport of `size` what stands over the frames of `scale`.

    Parameters
    ----------
    painter : QPainter
        In device-independent pixels.
    scale : TimelineScale
    size : QSize
    first_row : int
        Pixels of the lanes that are scrolled away above.
    """

    def __init__(
        self, painter: QPainter, scale: TimelineScale, size: QSize, first_row: int = 0
    ) -> None:
        self._painter, self._scale, self._size = painter, scale, size
        self._first_row = first_row
        self._theme = current_theme()

    def lanes(
        self, lanes: Sequence[Lane], tall: int, selected: Collection[str], ratio: float
    ) -> None:
        """Paint strips of lanes `tall` pixels high, `ratio` device pixels for one, and names."""
        painter, scale, theme = self._painter, self._scale, self._theme
        high, width = tall - _LANE_GAP, int(scale.left)
        if scale.frame_count:
            columns = max(1, round(scale.width * ratio))
            edges, rows = scale.edges(columns), max(4, round(high * ratio))
            for lane, top in self._seen(lanes, tall):
                pixels = strip_pixels(lane, edges, rows, theme)
                form = QImage.Format.Format_RGBA8888
                image = QImage(pixels.data, columns, rows, 4 * columns, form)
                painter.drawImage(QRectF(scale.left, top, scale.width, high), image)
                if lane.kind == "bars":
                    self._bar_labels(lane, top, high)
        names = QRectF(0, RULER_HEIGHT, width - 2, self._size.height())
        painter.fillRect(names, QColor(theme.window))
        for lane, top in self._seen(lanes, tall):
            if lane.id in selected:
                painter.fillRect(QRectF(0, top, width - 2, tall), QColor(theme.selection))
            painter.fillRect(QRectF(8, top + 3, 4, high - 6), QColor(lane.colour))
            self._text(QRectF(18, top, width - 26, high), lane.name, theme.text)

    def _seen(self, lanes: Sequence[Lane], tall: int) -> Iterator[tuple[Lane, int]]:
        """Lanes that are to be seen, with their upper ends."""
        for index, lane in enumerate(lanes):
            top = RULER_HEIGHT + index * tall - self._first_row
            if top + tall >= RULER_HEIGHT and top <= self._size.height():
                yield lane, top

    def _bar_labels(self, lane: Lane, top: float, high: int) -> None:
        scale, theme = self._scale, self._theme
        bright = QColor(lane.colour).lightnessF() > 0.5
        dark, light = sorted((theme.base, theme.text), key=lambda c: QColor(c).lightnessF())
        inside = (s for s in lane.spans if s.last >= scale.first and s.first < scale.last)
        for span in [s for s in inside if s.label][:_LABELLED_BARS]:
            left = max(scale.x_of(span.first), scale.left)
            right = min(scale.x_of(span.last + 1), scale.left + scale.width)
            if right - left >= 28.0:
                box = QRectF(left + 4.0, top, right - left - 8.0, high)
                self._text(box, span.label, dark if bright else light)

    def _text(self, box: QRectF, text: str, colour: str) -> None:
        """Write at the left of a box, cut where there is no room."""
        metrics = QFontMetricsF(self._painter.font())
        self._painter.setPen(QColor(colour))
        shown = metrics.elidedText(text, Qt.TextElideMode.ElideRight, box.width())
        self._painter.drawText(box, _LEFT, shown)

    def ruler(self, fps: float) -> None:
        """Write frame numbers over the lanes, and how long the recording is."""
        painter, scale, theme = self._painter, self._scale, self._theme
        width = self._size.width()
        painter.fillRect(QRectF(0, 0, width, RULER_HEIGHT), QColor(theme.raised))
        painter.setPen(QColor(theme.border))
        painter.drawLine(QPointF(0, RULER_HEIGHT - 0.5), QPointF(width, RULER_HEIGHT - 0.5))
        if not scale.frame_count:
            box = QRectF(8, 0, width, RULER_HEIGHT)
            self._text(box, "no recording is open", theme.muted)
            return
        for frame in scale.ticks():
            x = scale.x_of(frame)
            painter.setPen(QColor(theme.disabled))
            painter.drawLine(QPointF(x, RULER_HEIGHT - 7), QPointF(x, RULER_HEIGHT - 1))
            painter.setPen(QColor(theme.muted))
            if x + 40 < width:
                painter.drawText(QPointF(x + 4, RULER_HEIGHT - 8), str(frame))
        length = f"{scale.frame_count} fr, {time_text(scale.frame_count, fps)}"
        painter.drawText(QRectF(8, 0, scale.left - 16, RULER_HEIGHT), _LEFT, length)

    def hint(self, text: str) -> None:
        """Say in the room of the lanes why there are none."""
        left, size = self._scale.left, self._size
        box = QRectF(left, RULER_HEIGHT, size.width() - left, size.height() - RULER_HEIGHT)
        self._painter.setPen(QColor(self._theme.muted))
        flags = Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap
        self._painter.drawText(box, flags, text)

    def selection(self, selection: range) -> None:
        """Shade the selected frames."""
        painter, scale, height = self._painter, self._scale, self._size.height()
        left = max(scale.x_of(selection.start), scale.left)
        right = min(scale.x_of(selection.stop), scale.left + scale.width)
        if right <= left:
            return
        colour, faint = QColor(self._theme.accent), QColor(self._theme.accent)
        faint.setAlpha(46)
        painter.fillRect(QRectF(left, 0, right - left, 4), colour)
        painter.fillRect(QRectF(left, 0, right - left, height), faint)
        painter.setPen(QPen(colour, 1.0))
        painter.drawLine(QPointF(left, 0), QPointF(left, height))
        painter.drawLine(QPointF(right, 0), QPointF(right, height))

    def playhead(self, frame: int) -> None:
        """Draw the playhead over the frame, with its number in the ruler."""
        painter, scale, theme = self._painter, self._scale, self._theme
        left, right = scale.x_of(frame), scale.x_of(frame + 1)
        middle, height = (left + right) / 2, self._size.height()
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
        foot, tip = RULER_HEIGHT - 7.5, QPointF(middle, RULER_HEIGHT - 1.5)
        painter.drawPolygon(QPolygonF([QPointF(middle - 4, foot), QPointF(middle + 4, foot), tip]))
        painter.setPen(QColor(theme.window if theme.is_dark else theme.base))
        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, text)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing, False)
