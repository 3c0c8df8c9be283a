"""A person in a few lines, with dots where landmarks are."""

from __future__ import annotations

from dataclasses import dataclass

from PySide6.QtCore import QLineF, QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QHelpEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QToolTip, QWidget

from ..style.theme import current_theme

_RADIUS = 5.0


@dataclass(frozen=True)
class Sketch:
    """What is drawn; metres to the right and down."""

    lines: tuple[tuple[tuple[float, float], tuple[float, float]], ...] = ()
    """Tuple of ((x, y), (x, y)). The body."""
    dots: tuple[tuple[float, float, str, str], ...] = ()
    """Tuple of (x, y, colour, label)."""


class BodySketch(QWidget):
    """The sketch as large as there is room."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._sketch = Sketch()
        self._selected = -1
        self.setMinimumSize(180, 260)
        self.setAccessibleName("Positions of the landmarks on the body")
        self.setToolTip("Front view: the person's left side is on the right.")

    def sizeHint(self) -> QSize:
        return QSize(220, 340)

    def show_sketch(self, sketch: Sketch, selected: str = "") -> None:
        """Draw this; the dot of that label stands out."""
        self._sketch = sketch
        labels = [label for *_, label in sketch.dots]
        self._selected = labels.index(selected) if selected in labels else -1
        self.update()

    def _placed(self) -> tuple[float, QPointF]:
        """Pixels for a metre, and where the origin is."""
        points = [point for line in self._sketch.lines for point in line]
        points += [(x, y) for x, y, *_ in self._sketch.dots]
        if not points:
            return 1.0, QPointF()
        xs, ys = [p[0] for p in points], [p[1] for p in points]
        box = QRectF(min(xs), min(ys), max(max(xs) - min(xs), 0.1), max(max(ys) - min(ys), 0.1))
        scale = min((self.width() - 36) / box.width(), (self.height() - 60) / box.height())
        middle = QPointF(self.width() / 2.0, self.height() / 2.0) - box.center() * scale
        return scale, middle

    def paintEvent(self, _event: QPaintEvent) -> None:
        theme = current_theme()
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.fillRect(self.rect(), QColor(theme.base))
        scale, origin = self._placed()
        pen = QPen(QColor(theme.disabled), 7.0)
        pen.setCapStyle(Qt.PenCapStyle.RoundCap)
        painter.setPen(pen)
        for first, second in self._sketch.lines:
            ends = (QPointF(*first) * scale + origin, QPointF(*second) * scale + origin)
            painter.drawLine(QLineF(*ends))
        for place, (x, y, colour, _label) in enumerate(self._sketch.dots):
            middle = QPointF(x, y) * scale + origin
            chosen = place == self._selected
            painter.setPen(QPen(QColor(theme.text if chosen else theme.base), 2.0))
            painter.setBrush(QColor(colour))
            radius = _RADIUS + 2.5 if chosen else _RADIUS
            painter.drawEllipse(middle, radius, radius)
        painter.setPen(QColor(theme.muted))
        foot = QRectF(8, self.height() - 22, self.width() - 16, 18)
        painter.drawText(foot, Qt.AlignmentFlag.AlignLeft, "right")
        painter.drawText(foot, Qt.AlignmentFlag.AlignRight, "left")
        painter.end()

    def event(self, event: object) -> bool:
        if isinstance(event, QHelpEvent):
            label = self.label_at(QPointF(event.pos()))
            QToolTip.showText(event.globalPos(), label or self.toolTip(), self)
            return True
        return super().event(event)  # type: ignore[arg-type]

    def label_at(self, place: QPointF) -> str:
        """Label of the dot near a place; empty where there is none."""
        scale, origin = self._placed()
        for x, y, _colour, label in self._sketch.dots:
            away = QPointF(x, y) * scale + origin - place
            if away.manhattanLength() < 2 * _RADIUS:
                return label
        return ""
