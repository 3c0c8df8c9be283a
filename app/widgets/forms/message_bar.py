"""A bar that says what is wrong, where, and what to do about it."""

from __future__ import annotations

from PySide6.QtCore import QEvent, Qt, Signal
from PySide6.QtWidgets import (
    QFrame,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QSizePolicy,
    QToolButton,
    QWidget,
)

from ..style.icons import set_icon
from ..style.theme import current_theme
from .message import Message

_ICONS = {"error": "warning", "warning": "warning", "note": "info"}


class MessageBar(QFrame):
    """Shows one message until it is closed; further ones are counted and wait their turn.

    Signals
    -------
    dismissed : Message
        A person has closed this message without doing what it offers.
    """

    dismissed = Signal(object)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._messages: list[Message] = []
        self._icon = QToolButton()
        self._icon.setEnabled(False)
        self._icon.setAutoRaise(True)
        self._text = QLabel()
        self._text.setWordWrap(True)
        self._text.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._text.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.MinimumExpanding)
        self._more = QLabel()
        self._more.setProperty("role", "muted")
        self.do_button = QPushButton()
        self.do_button.clicked.connect(self._do)
        self.close_button = QToolButton()
        self.close_button.setToolTip("Dismiss this message")
        self.close_button.setAutoRaise(True)
        set_icon(self.close_button, "close")
        self.close_button.clicked.connect(self.dismiss)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(8, 4, 8, 4)
        layout.addWidget(self._icon)
        layout.addWidget(self._text, 1)
        layout.addWidget(self.do_button)
        layout.addWidget(self._more)
        layout.addWidget(self.close_button)
        self.setAccessibleName("Messages")
        self.hide()

    @property
    def message(self) -> Message | None:
        """What is shown."""
        return self._messages[-1] if self._messages else None

    def text(self) -> str:
        """What is written."""
        return self._messages[-1].sentence() if self._messages else ""

    def show_message(self, message: Message) -> None:
        """Show a message above those that are there; the same one is not shown twice."""
        if message not in self._messages:
            self._messages.append(message)
        self._refresh()

    def close_message(self) -> None:
        """Close the message that is shown."""
        if self._messages:
            self._messages.pop()
        self._refresh()

    def dismiss(self) -> None:
        """Close the message that is shown, because the person does not want it."""
        message = self.message
        self.close_message()
        if message is not None:
            self.dismissed.emit(message)

    def take_back(self, message: Message) -> None:
        """Remove a message that holds no longer."""
        if message in self._messages:
            self._messages.remove(message)
            self._refresh()

    def clear(self) -> None:
        """Close all messages."""
        self._messages.clear()
        self._refresh()

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange:
            self._dress()

    def _do(self) -> None:
        message = self.message
        self.close_message()
        if message is not None and message.do is not None:
            message.do()

    def _refresh(self) -> None:
        message = self.message
        self.setVisible(message is not None)
        if message is None:
            return
        self._text.setText(message.sentence())
        self.do_button.setVisible(bool(message.button))
        self.do_button.setText(message.button)
        waiting = len(self._messages) - 1
        self._more.setText(f"and {waiting} more" if waiting else "")
        set_icon(self._icon, _ICONS[message.severity])
        self._dress()

    def _dress(self) -> None:
        message, theme = self.message, current_theme()
        if message is None:
            return
        colour = {"error": theme.error, "warning": theme.warning}.get(
            message.severity, theme.accent
        )
        sheet = (
            f"MessageBar {{ background: {theme.raised}; border: none;"
            f" border-left: 4px solid {colour}; border-bottom: 1px solid {theme.border}; }}"
        )
        if sheet != self.styleSheet():
            self.setStyleSheet(sheet)
