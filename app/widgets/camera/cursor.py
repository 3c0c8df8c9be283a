"""What follows the cursor: what a click would do, and a loupe, every pixel a square."""

from collections.abc import Iterator
from contextlib import contextmanager

from PySide6.QtCore import QPointF, QRect, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPainterPath, QPaintEvent, QPen, QTransform
from PySide6.QtWidgets import QLabel, QWidget

from .overlays import stroke

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
    " border-radius: 4px;"
)
_PLAIN = "#FFFFFF"
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
                f"{_BOX} color: {_PLAIN};"
                f" padding: 0 {_PADDING}px 0 {self._indent()}px;"
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
            painter.setPen(QColor(_PLAIN))
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
