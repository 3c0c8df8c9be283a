"""The parts of the timeline as they are painted: lanes, ruler, selection, playhead."""

from collections.abc import Collection, Iterator, Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QFontMetricsF, QImage, QPainter, QPen, QPolygonF

from stereotrack_core.arrays import FloatArray, ImageArray

from ..style.theme import Theme, current_theme
from .lanes import Lane, Mark, TimelineScale


@lru_cache(maxsize=64)  # an edit changes few of the lanes
def strip_between(
    lane: Lane, first: float, last: float, size: tuple[int, int], theme: Theme
) -> ImageArray:
    """Picture of a lane between two frames, of a size (columns, rows)."""
    return strip_pixels(lane, np.linspace(first, last, size[0] + 1), size[1], theme)


def strip_pixels(lane: Lane, edges: FloatArray, height: int, theme: Theme) -> ImageArray:
    """Picture (height, C, 4) RGBA of a lane, with the frames at the columns' edges (C + 1,)."""
    whole = np.full((height, len(edges) - 1), _number(theme.base))
    pixels = whole.view(np.uint8).reshape(*whole.shape, 4)
    has_values = len(lane.values) > 0
    if lane.kind == "bars":
        _paint_bars(pixels, lane, edges)
    elif lane.kind == "marks" and has_values:
        _paint_marks(pixels, lane, edges, theme)
    elif has_values:
        _paint_heat(pixels, lane, edges, theme)
    return pixels


def heat_colours(values: FloatArray, full: float, colour: str, theme: Theme) -> ImageArray:
    """Colours (C, 4) of values: from the background over the limb's colour to the text's.

    The lightness runs one way, so that the order is seen without telling hues apart. NaN is
    left transparent.
    """
    stops = np.array([rgba(theme.base), rgba(colour), rgba(theme.text)], dtype=np.float64)
    share = np.clip(np.nan_to_num(values) / full, 0.0, 1.0)
    # the limb's own colour stands at two thirds, the last third warns
    places = np.array([0.0, 0.66, 1.0])
    result = np.stack([np.interp(share, places, stops[:, k]) for k in range(4)], axis=1)
    result[np.isnan(values)] = (0, 0, 0, 0)
    colours: ImageArray = result.astype(np.uint8)
    return colours


def rgba(colour: str) -> NDArray[np.uint8]:
    """Red, green, blue and full opacity (4,) of #rrggbb."""
    return np.array([*bytes.fromhex(colour[1:]), 255], dtype=np.uint8)


def _paint_heat(pixels: ImageArray, lane: Lane, edges: FloatArray, theme: Theme) -> None:
    values = np.asarray(lane.columns(edges), dtype=np.float64)
    known = ~np.isnan(values)
    colours = heat_colours(values, lane.full_value, lane.colour, theme)
    pixels[1:-1, known] = colours[known]
    # what is not known is not zero: a thin line in the middle instead of an empty strip
    dots = ~known & (np.arange(pixels.shape[1]) % 4 < 2)
    pixels[pixels.shape[0] // 2, dots] = rgba(theme.disabled)


def _paint_marks(pixels: ImageArray, lane: Lane, edges: FloatArray, theme: Theme) -> None:
    bits = np.asarray(lane.columns(edges), dtype=np.uint8)
    height = pixels.shape[0]
    middle = height // 2
    half = max(1, height // 12)

    def has(mark: Mark) -> NDArray[np.bool_]:
        return (bits & (1 << mark)) > 0

    # a pixel as one number: painting it is several times as fast as painting four
    whole = pixels.view(np.uint32)[..., 0]
    colour = _number(lane.colour)
    _stripe(whole, has(Mark.GAP), _number(theme.disabled))
    _stripe(whole, _widened(has(Mark.PROPOSED), edges), colour)
    whole[middle - half : middle + half, has(Mark.INTERPOLATED)] = colour
    whole[middle:-1, _widened(has(Mark.PARTLY), edges)] = colour
    whole[-max(2, height // 6) :, has(Mark.MISSING)] = _number(theme.error)
    flagged = _widened(has(Mark.FLAGGED), edges)
    whole[1:-1, _widened(has(Mark.CLICKED), edges) | flagged] = colour
    whole[: max(3, height // 3), flagged] = _number(theme.warning)


def _number(colour: str) -> np.uint32:
    number: np.uint32 = rgba(colour).view(np.uint32)[0]
    return number


def _stripe(whole: NDArray[np.uint32], columns: NDArray[np.bool_], colour: np.uint32) -> None:
    # slanted lines over the whole height: nothing is clicked there, on purpose or not yet
    places, rows = np.flatnonzero(columns), np.arange(1, len(whole) - 1)[:, None]
    slanted = (rows + places) % 6 < 2
    whole[1:-1, places] = np.where(slanted, colour, whole[1:-1, places])


def _widened(columns: NDArray[np.bool_], edges: FloatArray) -> NDArray[np.bool_]:
    # one click among many frames has to be seen: two pixels at least
    per_column = (edges[-1] - edges[0]) / max(len(edges) - 1, 1)
    if per_column < 0.5:
        return columns
    result = columns.copy()
    result[1:] |= columns[:-1]
    return result


def _paint_bars(pixels: ImageArray, lane: Lane, edges: FloatArray) -> None:
    inset, width = max(1, pixels.shape[0] // 8), (edges[-1] - edges[0]) / (len(edges) - 1)
    for span in lane.spans:
        if span.last + 1 > edges[0] and span.first < edges[-1]:
            first = max(int((span.first - edges[0]) / width), 0)
            last = max(int(np.ceil((span.last + 1 - edges[0]) / width)), first + 1)
            pixels[inset:-inset, first:last] = rgba(lane.colour)


RULER_HEIGHT = 24
LEAST_LANE, MOST_LANE = 13, 20  # heights between which lanes take what room there is
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

    `first_row` are the pixels of the lanes that are scrolled away above.
    """

    def __init__(
        self, painter: QPainter, scale: TimelineScale, size: QSize, first_row: int = 0
    ) -> None:
        self._painter, self._scale, self._size = painter, scale, size
        self._first_row = first_row
        self._theme = current_theme()

    def strips(self, lanes: Sequence[Lane], tall: int, ratio: float) -> None:
        """Paint strips `tall` pixels high, `ratio` device pixels for one."""
        scale, high = self._scale, tall - _LANE_GAP
        size = columns, rows = max(1, round(scale.width * ratio)), max(4, round(high * ratio))
        for lane, top in self._seen(lanes, tall) if scale.frame_count else ():
            pixels = strip_between(lane, scale.first, scale.last, size, self._theme)
            form = QImage.Format.Format_RGBA8888
            image = QImage(pixels.data, columns, rows, 4 * columns, form)
            self._painter.drawImage(QRectF(scale.left, top, scale.width, high), image)
            if lane.kind == "bars":
                self._bar_labels(lane, top, high)

    def names(self, lanes: Sequence[Lane], tall: int, selected: Collection[str]) -> None:
        painter, theme = self._painter, self._theme
        high, width = tall - _LANE_GAP, int(self._scale.left)
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
        left, size = self._scale.left, self._size
        box = QRectF(left, RULER_HEIGHT, size.width() - left, size.height() - RULER_HEIGHT)
        self._painter.setPen(QColor(self._theme.muted))
        flags = Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap
        self._painter.drawText(box, flags, text)

    def selection(self, selection: range) -> None:
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

    def hover(self, frame: int) -> None:
        scale = self._scale
        middle = (scale.x_of(frame) + scale.x_of(frame + 1)) / 2
        if scale.left <= middle <= scale.left + scale.width:
            self._painter.setPen(QPen(QColor(self._theme.muted), 1.0))
            self._painter.drawLine(QPointF(middle, 0), QPointF(middle, self._size.height()))

    def playhead(self, frame: int) -> None:
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
