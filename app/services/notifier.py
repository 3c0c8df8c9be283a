"""What a person is told: messages that stay, and words in the status line."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QObject, Signal, Slot

from stereotrack_core.errors import InputError

from ..widgets.forms.message import Message
from .failures import message_of

SAID_MS = 6000


class Notifier(QObject):
    """Tells the window what to show; knows nothing of how.

    Signals
    -------
    shown : Message
        Something that the person should read.
    taken_back : Message
        It holds no longer.
    cleared : ()
        No message holds any longer.
    dismissed : Message
        A person has closed this message without doing what it offers.
    said : str, int
        Words for the status line, and for how many milliseconds.
    """

    shown = Signal(object)
    taken_back = Signal(object)
    cleared = Signal()
    dismissed = Signal(object)
    said = Signal(str, int)

    @Slot(object)
    def show(self, message: Message) -> None:
        """Show a message until it is closed."""
        self.shown.emit(message)

    @Slot(object)
    def error(self, error: BaseException) -> None:
        """Show what went wrong in words."""
        self.shown.emit(message_of(error))

    def attempt(self, do: Callable[[], object]) -> bool:
        """Do something; where it cannot be done, show why."""
        try:
            do()
        except (InputError, OSError) as error:
            self.error(error)
            return False
        return True

    def take_back(self, message: Message) -> None:
        """Remove a message that holds no longer."""
        self.taken_back.emit(message)

    def clear(self) -> None:
        """Close all messages."""
        self.cleared.emit()

    @Slot(str)
    def say(self, words: str, milliseconds: int = SAID_MS) -> None:
        """Say something in the status line, for a while."""
        self.said.emit(words, milliseconds)
