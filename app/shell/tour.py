"""A tour of the window in five steps, on the demo where nothing is open."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtCore import QEvent, QObject, QPoint, QRect, Qt, QTimer, Signal, Slot
from PySide6.QtGui import QColor, QKeyEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QMainWindow, QWidget

from ..context import Context
from ..widgets.forms.form_dialog import push_button
from ..widgets.forms.message import Message
from ..widgets.style.building import hbox, label, vbox
from ..widgets.style.theme import Dressed, current_theme

_OFFERED = "tour_offered"
_GEOMETRY = "geometry"
"""Settings that a window leaves when it has been there before."""
_WIDTH, _GAP = 340, 12
_KEYS: dict[int, int] = {
    Qt.Key.Key_Right: 1, Qt.Key.Key_Return: 1, Qt.Key.Key_Left: -1, Qt.Key.Key_Escape: 0
}  # fmt: skip
"""Steps that a key goes on; 0 ends the tour."""


@dataclass(frozen=True)
class Step:
    """One stop of the tour."""

    title: str
    text: str
    target: Callable[[], QWidget]
    """What it points at."""


class _Ring(QWidget):
    """A frame around what a step is about; it takes no clicks."""

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(QColor(current_theme().accent), 3))
        painter.drawRoundedRect(self.rect().adjusted(2, 2, -2, -2), 6, 6)


class _Card(Dressed):
    """What a step says, with the buttons that go on, back and away."""

    moved = Signal(int)
    left = Signal()

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self.setObjectName("tour")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.setAccessibleName("Tour")
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.title, self.text = label("", "heading"), label()
        self.place = label("", "muted", wraps=False)
        self.back = push_button("Back", lambda: self.moved.emit(-1))
        self.next = push_button("Next", lambda: self.moved.emit(1))
        self.leave = push_button("End tour", self.left.emit, "End the tour (Esc)")
        buttons = hbox(self.place, None, self.leave, self.back, self.next, spacing=6)
        self.setLayout(vbox(self.title, self.text, buttons, margins=(14, 12, 14, 12), spacing=10))
        self.setFixedWidth(_WIDTH)
        self._dress()

    def say(self, step: Step, number: int, count: int) -> None:
        """Show a step."""
        self.title.setText(step.title)
        self.text.setText(step.text)
        self.place.setText(f"{number} of {count}")
        self.back.setEnabled(number > 1)
        self.next.setText("Next" if number < count else "Finish")
        self.leave.setVisible(number < count)
        self.adjustSize()

    def event(self, event: QEvent) -> bool:
        is_key = isinstance(event, QKeyEvent) and event.key() in _KEYS
        if is_key and event.type() == QEvent.Type.ShortcutOverride:
            event.accept()  # these keys step through frames too
        return super().event(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        by = _KEYS.get(event.key())
        if by is None:
            super().keyPressEvent(event)
        elif by:
            self.moved.emit(by)
        else:
            self.left.emit()

    def _dress(self) -> None:
        theme = current_theme()
        sheet = (
            f"#tour {{ background: {theme.raised}; border: 1px solid {theme.accent};"
            f" border-radius: {theme.radius}px; }}"
        )
        if sheet != self.styleSheet():
            self.setStyleSheet(sheet)


class Tour(QObject):
    """Walks through the window; nothing is locked meanwhile, and it can be ended at any step."""

    def __init__(self, window: QMainWindow, context: Context, steps: tuple[Step, ...]) -> None:
        super().__init__(window)
        self._window, self._context, self._steps = window, context, steps
        self._at, self._begins = 0, False
        self._offer: Message | None = None
        self.ring: _Ring | None = None
        self.card: _Card | None = None
        session = context.session
        session.ready.connect(self._on_ready)
        session.closed.connect(self.end)
        context.notifier.dismissed.connect(self._on_dismissed)

    def offer(self) -> None:
        """Offer the tour on the very first start; never again."""
        settings = self._context.settings
        if settings.contains(_OFFERED) or settings.contains(_GEOMETRY):
            return
        settings.setValue(_OFFERED, True)
        self._offer = Message(
            "note", "New here? A tour shows the window in five steps",
            remedy="It opens a demo if no recording is open. You find it in the Help menu later.",
            button="Start tour", do=self.start,
        )  # fmt: skip
        self._context.notifier.show(self._offer)

    def start(self) -> None:
        """Begin with the first step; without a recording, open the demo first."""
        self._offer = None
        if self._context.session.document.recording is None:
            self._begins = True
            self._context.notifier.say("The tour starts as soon as the demo is open.")
            self._context.actions.action("demo").trigger()
            return
        self.end()
        if self._context.docks.workspace != "track":
            self._context.docks.show_named("track")
        self.ring, self.card = _Ring(self._window), _Card(self._window)
        self.card.moved.connect(self._move)
        self.card.left.connect(self.end)
        self._at = 0
        self._window.installEventFilter(self)
        QTimer.singleShot(0, self, self._show)  # when the panels have their places

    @Slot()
    def end(self) -> None:
        """Take the card away."""
        for part in (self.ring, self.card):
            if part is not None:
                part.hide()
                part.deleteLater()
        self.ring = self.card = None
        self._window.removeEventFilter(self)

    def eventFilter(self, _window: QObject, event: QEvent) -> bool:
        if event.type() in (QEvent.Type.Resize, QEvent.Type.LayoutRequest):
            QTimer.singleShot(0, self, self._place)
        return False

    @Slot(int)
    def _move(self, by: int) -> None:
        self._at = max(self._at + by, 0)
        if self._at < len(self._steps):
            self._show()
        else:
            self.end()

    @Slot()
    def _show(self) -> None:
        if self.card is None:
            return
        self.card.say(self._steps[self._at], self._at + 1, len(self._steps))
        self._place()
        self.card.show()
        self.card.raise_()
        self.card.setFocus()

    @Slot()
    def _place(self) -> None:
        """Put the frame around what the step is about, and the card beside it."""
        if self.card is None or self.ring is None:
            return
        target = self._steps[self._at].target()
        self.ring.setVisible(target.isVisible())
        inside = self._window.rect()
        around = QRect(target.mapTo(self._window, QPoint(0, 0)), target.size())
        self.ring.setGeometry(around.adjusted(-4, -4, 4, 4).intersected(inside))
        self.ring.raise_()
        self.card.move(_beside(around, QRect(QPoint(0, 0), self.card.size()), inside))
        self.card.raise_()

    @Slot()
    def _on_ready(self) -> None:
        self.end()
        if self._begins:
            self._begins = False
            QTimer.singleShot(0, self, self.start)
        elif self._offer is not None:  # opening has cleared it away
            QTimer.singleShot(0, self, self._offer_again)

    @Slot()
    def _offer_again(self) -> None:
        if self._offer is not None:
            self._context.notifier.show(self._offer)

    @Slot(object)
    def _on_dismissed(self, message: Message) -> None:
        if message is self._offer:
            self._offer = None


def _beside(target: QRect, card: QRect, inside: QRect) -> QPoint:
    """Place of the card: below, above, right or left of the target, or else in its middle."""
    middle = card.translated(target.center() - card.center())
    room = inside.adjusted(_GAP, _GAP, -_GAP, -_GAP)
    level = min(max(middle.left(), room.left()), room.right() - card.width())
    upright = min(max(middle.top(), room.top()), room.bottom() - card.height())
    places = (
        QPoint(level, target.bottom() + _GAP),
        QPoint(level, target.top() - card.height() - _GAP),
        QPoint(target.right() + _GAP, upright),
        QPoint(target.left() - card.width() - _GAP, upright),
    )
    fits = (place for place in places if room.contains(QRect(place, card.size())))
    return next(fits, QPoint(level, upright))
