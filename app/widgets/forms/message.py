"""Messages, and the bars below the views that show them and say what state the views are in."""

from collections.abc import Callable
from functools import partial

from PySide6.QtCore import QEvent, QMargins, QObject, Qt, QTimer, Signal
from PySide6.QtWidgets import QApplication, QPushButton, QSizePolicy, QWidget

from ...session.messages import Message
from ..style.building import Raised, hbox, label, named, tool_button, vbox
from ..style.theme import icon_named, set_look

_ICONS = {"error": "warning", "warning": "warning", "note": "info"}


_PRESSED_MS = 100  # pause after which a mouse button may be released


class BarsBelow(QWidget):
    """Lies at the lower end of a widget, which leaves it room, with the bars that are shown there.

    While a mouse button is pressed nothing moves: a click lands where the person has aimed.
    """

    def __init__(self, under: QWidget) -> None:
        super().__init__(under)
        self._under = under
        self.column = vbox(spacing=0)
        self.setLayout(self.column)
        under.installEventFilter(self)

    def event(self, event: QEvent) -> bool:
        if event.type() == QEvent.Type.LayoutRequest:
            self._place()
        return super().event(event)

    def eventFilter(self, _under: QObject, event: QEvent) -> bool:
        if event.type() == QEvent.Type.Resize:
            self._place()
        return False

    def _place(self) -> None:
        if QApplication.mouseButtons():
            QTimer.singleShot(_PRESSED_MS, self, self._place)
            return
        column, width = self.column, self._under.width()
        high = column.heightForWidth(width) if column.hasHeightForWidth() else -1
        height = high if high >= 0 else column.sizeHint().height()
        self._under.setContentsMargins(QMargins(0, 0, 0, height))
        self.setGeometry(0, self._under.height() - height, width, height)
        self.raise_()


class StateBar(Raised):
    """Says what state the views are in while it lasts, and ends it with a button."""

    def __init__(self, name: str, button: str, tip: str) -> None:
        super().__init__("bar")
        self.words = label()
        self.words.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        self.button = named(QPushButton(button), tip=tip)
        self.setLayout(hbox((self.words, 1), self.button, margins=(8, 4, 8, 4)))
        self.setAccessibleName(name)
        self.hide()

    def show_words(self, words: str) -> None:
        """Say this; nothing to say hides the bar."""
        self.words.setText(words)
        self.setVisible(bool(words))


class MessageBar(Raised):
    """Shows one message until it is closed; further ones are counted and wait their turn."""

    dismissed = Signal(object)  # A person has closed this `Message` without doing what it offers

    def __init__(self) -> None:
        super().__init__("bar")
        self._messages: list[Message] = []
        self.other_buttons: list[QPushButton] = []
        self._icon = tool_button("Message")
        self._icon.setEnabled(False)
        self._icon.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self._text = label(copied=True)
        self._text.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.MinimumExpanding)
        self._more = label("", "muted", wraps=False)
        self.do_button = QPushButton()
        self.do_button.clicked.connect(lambda: self._do())
        self.close_button = tool_button("Dismiss this message", "close", do=self.dismiss)
        parts = (self._icon, (self._text, 1), self.do_button, self._more, self.close_button)
        self._row = hbox(*parts, margins=(8, 4, 8, 4))
        self.setLayout(self._row)
        self.setAccessibleName("Messages")
        self.hide()

    @property
    def message(self) -> Message | None:
        return self._messages[-1] if self._messages else None

    def text(self) -> str:
        return self.message.sentence() if self.message is not None else ""

    def show_message(self, message: Message) -> None:
        """Show a message above those that are there; the same one is not shown twice."""
        if message not in self._messages:
            self._messages.append(message)
        self._refresh()

    def dismiss(self) -> None:
        """Close the message that is shown, because the person does not want it."""
        if (message := self.message) is not None:
            self.take_back(message)
            self.dismissed.emit(message)

    def take_back(self, message: Message) -> None:
        if message in self._messages:
            self._messages.remove(message)
            self._refresh()

    def clear(self) -> None:
        self._messages.clear()
        self._refresh()

    def _do(self, do: Callable[[], None] | None = None) -> None:
        """Do what the message that is shown offers, or something else that it offers."""
        message = self.message
        if message is not None and (do := do or message.do) is not None:
            self.take_back(message)
            do()

    def _refresh(self) -> None:
        message, waiting = self.message, len(self._messages) - 1
        self.setVisible(message is not None)
        if message is not None:
            self._text.setText(message.sentence())
            self.do_button.setVisible(bool(message.button))
            self.do_button.setText(message.button)
            for old in self.other_buttons:
                old.hide()
                old.deleteLater()
            self.other_buttons = [QPushButton(words) for words, _do in message.others]
            for button, (_words, do) in zip(self.other_buttons, message.others, strict=True):
                button.clicked.connect(partial(self._do, do))
                self._row.insertWidget(self._row.indexOf(self._more), button)
            self._more.setText(f"and {waiting} more" if waiting else "")
            self._icon.setIcon(icon_named(_ICONS[message.severity]))
            set_look(self, "edge", message.severity)
