"""The mouse over a picture: what a click means and would do, and a loupe at the cursor."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

from PySide6.QtCore import QLineF, QPointF, QRect, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPainterPath, QPaintEvent, QPen, QTransform
from PySide6.QtWidgets import QLabel, QWidget

from .click_marks import ClickAct, ClickMark, ClickMarks, Offer, PredictionMark
from .overlays import stroke
from .picture import PictureView

HANDLE = 12.0  # widget pixels around a click within which it can be dragged
_STILL = 3.0
_Mark = TypeVar("_Mark", ClickMark, PredictionMark)


@dataclass
class _Press:
    start: QPointF
    now: QPointF
    mark: ClickMark | PredictionMark | None
    offset: QPointF
    dragging: bool = False


class ClickHand:
    """From presses and moves of the left button to what they mean.

    A press within :data:`HANDLE` of a click that moves drags it; a proposal that is dragged becomes
    a click where it is dropped. A press that stays places the
    landmark that is offered, be it on another one's click: hands do lie on elbows. Only when that
    has been clicked in this picture already, or everything has, a press on a handle picks that
    click; with Ctrl it places even then.
    """

    def __init__(self, ground: PictureView) -> None:
        self._ground = ground
        self._press: _Press | None = None

    @property
    def dragging(self) -> bool:
        return self._press is not None and self._press.dragging

    @property
    def busy(self) -> bool:
        return self._press is not None

    def preview(self) -> tuple[str, QPointF] | None:
        press = self._press
        if press is None or press.mark is None or not press.dragging:
            return None
        return press.mark.landmark, self._ground.pixel_at(press.now - press.offset)

    def press(self, position: QPointF, marks: ClickMarks) -> None:
        mark = self.handle_at(position, marks)
        place = self._ground.place_of(mark.x, mark.y) if mark is not None else position
        self._press = _Press(position, position, mark, position - place)

    def move(self, position: QPointF) -> None:
        if self._press is not None:
            self._press.now = position
            self._press.dragging |= (position - self._press.start).manhattanLength() > _STILL

    def let_go(self) -> None:
        self._press = None

    def release(
        self, position: QPointF, marks: ClickMarks, modifiers: Qt.KeyboardModifier
    ) -> ClickAct | None:
        """Act that ends with the button; None for none, as outside the picture."""
        self.move(position)
        press, self._press = self._press, None
        if press is None:
            return None
        anyway = bool(modifiers & Qt.KeyboardModifier.ControlModifier)
        if press.mark is not None and press.dragging and not anyway:
            pixel = self._ground.pixel_at(press.now - press.offset)
            if not self._ground.inside(pixel):
                return None
            key, moves = marks.key(press.mark.landmark), isinstance(press.mark, ClickMark)
            return ClickAct("move" if moves else "place", key, (pixel.x(), pixel.y()))
        offer = marks.offer
        if isinstance(press.mark, ClickMark) and not anyway and offer.picks:
            return ClickAct("pick", marks.key(press.mark.landmark))
        pixel = self._ground.pixel_at(position)
        if not self._ground.inside(pixel) or not offer.landmark:
            return None
        # with Shift the landmark is behind something
        shift = modifiers & Qt.KeyboardModifier.ShiftModifier
        key = marks.key(offer.landmark)
        return ClickAct("guess" if shift else "place", key, (pixel.x(), pixel.y()))

    def offer_at(self, position: QPointF, marks: ClickMarks) -> Offer:
        if marks.offer.picks and (mark := self.mark_at(position, marks)):
            return Offer(words=f"{mark.label}: click to select, drag to move", colour=mark.colour)
        return marks.offer

    def handle_at(self, position: QPointF, marks: ClickMarks) -> ClickMark | PredictionMark | None:
        """Mark to be dragged from a place in the widget: a click, else a proposal."""
        clicked = {mark.landmark for mark in marks.clicks}
        open_ones = [m for m in marks.predictions if m.proposed and m.landmark not in clicked]
        return self.mark_at(position, marks) or self._nearest(position, open_ones)

    def mark_at(self, position: QPointF, marks: ClickMarks) -> ClickMark | None:
        """The nearest click whose handle is under a place in the widget."""
        return self._nearest(position, marks.clicks)

    def _nearest(self, position: QPointF, marks: Sequence[_Mark]) -> _Mark | None:
        nearest = min(marks, key=partial(self._distance, position), default=None)
        far = nearest is None or self._distance(position, nearest) > HANDLE
        return None if far else nearest

    def _distance(self, position: QPointF, mark: ClickMark | PredictionMark) -> float:
        return QLineF(position, self._ground.place_of(mark.x, mark.y)).length()


SIZE = 170.0
FACTOR = 4.0
LEAST_SCALE = 5.0  # widget pixels that a pixel of the picture has in the loupe at least


def loupe_size(bounds: QRectF) -> float:
    """Diameter of the loupe in a widget of this size."""
    return min(SIZE, 0.62 * min(bounds.width(), bounds.height()))


@contextmanager
def loupe(
    painter: QPainter, cursor: QPointF, size: float, scale: float, rim: QColor
) -> Iterator[QTransform]:
    """Let what is painted meanwhile be seen in a circle of a diameter of `size` at the cursor.

    Gives the transform that enlarges the neighbourhood of the cursor, a place in the widget, which
    has `scale` pixels for one of the picture.
    """
    factor = max(FACTOR, LEAST_SCALE / max(scale, 1e-6))
    path = QPainterPath()
    path.addEllipse(cursor, 0.5 * size, 0.5 * size)
    painter.save()
    painter.setClipPath(path)
    painter.fillRect(path.boundingRect(), QColor("black"))
    around = QTransform.fromScale(factor, factor) * QTransform.fromTranslate(cursor.x(), cursor.y())
    yield QTransform.fromTranslate(-cursor.x(), -cursor.y()) * around
    cross = QPainterPath()
    for way in (QPointF(1, 0), QPointF(-1, 0), QPointF(0, 1), QPointF(0, -1)):
        cross.moveTo(cursor + way * 4.0)  # a gap, so that the pixel itself is seen
        cross.lineTo(cursor + way * (0.32 * size))
    stroke(painter, cross, QPen(QColor(0, 0, 0, 150), 3), QPen(QColor(255, 255, 255, 210), 1))
    painter.restore()
    stroke(painter, path, QPen(rim, 2))


_BOX = (
    "background: rgba(16, 16, 16, 225); border: 1px solid rgba(255, 255, 255, 90);"
    " border-radius: 4px; color: #FFFFFF;"
)
_WIDEST = 250
_PADDING = 5
_DOT = 4
_GAP = 16.0


class CursorLabel(QLabel):
    """A name, with a dot of its limb's colour, on a dark box that stays inside its parent."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self._ground = parent
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.setWordWrap(True)
        self.setIndent(0)
        self.colour = ""
        self.hide()

    @property
    def words(self) -> str:
        """What is said; empty while nothing is."""
        return self.text() if self.isVisibleTo(self._ground) else ""

    def say(self, words: str, colour: str, cursor: QPointF, clear: float = 0.0) -> None:
        """Say something beside the cursor, a place in the parent.

        `colour` is ``#rrggbb`` of what would be placed, or empty; `clear` are the pixels around the
        cursor that stay free, such as the loupe's.
        """
        if (words, colour) != (self.text(), self.colour):
            self.colour = colour
            self.setText(words)
            self.setAccessibleName(words)
            self.setStyleSheet(
                f"{_BOX} padding: 0 {_PADDING}px 0 {self._indent()}px;"
                f" font-weight: {'bold' if colour else 'normal'};"
            )
        size = self._size_in(self._ground.size())
        place = _beside(cursor, size, self._ground.rect(), max(_GAP, clear + 4.0))
        self.setGeometry(place)
        self.show()
        self.raise_()

    def paintEvent(self, event: QPaintEvent) -> None:
        super().paintEvent(event)
        if self.colour:  # the dot that a click would draw
            painter = QPainter(self)
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            painter.setPen(QColor("white"))
            painter.setBrush(QColor(self.colour))
            painter.drawEllipse(QPointF(_PADDING + _DOT, self.height() / 2), _DOT, _DOT)
            painter.end()

    def _indent(self) -> int:
        return _PADDING + (2 * _DOT + 5 if self.colour else 0)

    def _size_in(self, room: QSize) -> QSize:
        """As little as the words need; they are wrapped where the parent is narrow."""
        edge = _PADDING + self._indent()
        widest = QRect(0, 0, max(min(_WIDEST, room.width() - 4) - edge, 1), 10_000)
        self.ensurePolished()
        words = self.fontMetrics().boundingRect(widest, Qt.TextFlag.TextWordWrap, self.text())
        return QSize(words.width() + edge + 4, words.height() + _PADDING).boundedTo(room)


def _beside(cursor: QPointF, size: QSize, room: QRect, gap: float) -> QRect:
    """Below to the right of the cursor, or on whichever side there is room."""
    x, y = cursor.x(), cursor.y()
    width, height = size.width(), size.height()
    right, left = x + 0.75 * gap, x - 0.75 * gap - width
    below, above = y + gap, y - gap - height
    column = right if right + width <= room.right() - 1 else left
    row = below if below + height <= room.bottom() - 1 else above
    column = min(max(column, 2.0), max(room.width() - width - 2.0, 0.0))
    row = min(max(row, 2.0), max(room.height() - height - 2.0, 0.0))
    return QRect(round(column), round(row), width, height)
