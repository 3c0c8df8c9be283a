"""Messages and failures reach the window: below the views, and in the status line."""

import sys
import threading
from collections.abc import Callable
from functools import partial
from types import TracebackType

from PySide6.QtCore import QCoreApplication, QObject, Qt, Signal, Slot
from PySide6.QtWidgets import QStatusBar

from stereotrack_core.errors import InputError
from stereotrack_core.project.exporting import Exported

from ..session.messages import Message, Tell, message_of
from ..widgets.forms.message import MessageBar


class Post(QObject):
    """Calls functions in the window's thread, whichever thread posts them."""

    posted = Signal(object)

    def __init__(self) -> None:
        # it belongs to the program: a thread may post when the window is gone
        super().__init__(QCoreApplication.instance())
        self.posted.connect(self._call, Qt.ConnectionType.QueuedConnection)

    @Slot(object)
    def _call(self, do: Callable[[], object]) -> None:
        do()


class FailureRelay:
    """Tells exceptions that nobody caught, of any thread, as messages in the window's thread."""

    def __init__(self, tell: Tell) -> None:
        self._tell, self._post = tell, Post()
        self._before = sys.excepthook, threading.excepthook
        sys.excepthook = self._on_exception
        threading.excepthook = lambda one: self._on_exception(
            one.exc_type, one.exc_value, one.exc_traceback
        )

    def remove(self) -> None:
        """Leave exceptions to whoever had them before; a second time does nothing."""
        sys.excepthook, threading.excepthook = self._before

    def _on_exception(
        self, kind: type[BaseException], error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if error is not None and issubclass(kind, KeyboardInterrupt):
            sys.__excepthook__(kind, error, trace)
        elif error is not None and not issubclass(kind, SystemExit):
            message = message_of(error.with_traceback(trace))
            self._post.posted.emit(partial(self._tell, message))


SAID_MS = 6000


class Notifier:
    """Messages below the views, and words in the status line."""

    def __init__(self, bar: MessageBar, status: QStatusBar) -> None:
        self._bar, self._status, self.dismissed = bar, status, bar.dismissed
        self.take_back, self.clear = bar.take_back, bar.clear

    def show(self, message: Message) -> None:
        self._bar.show_message(message)

    def error(self, error: BaseException) -> None:
        self.show(message_of(error))

    def attempt(self, do: Callable[[], object]) -> bool:
        """Do something; where it cannot be done, show why."""
        try:
            do()
        except (InputError, OSError) as error:
            self.error(error)
            return False
        return True

    def exported(self, done: Exported) -> None:
        """Say what was written; remarks on it stay until a person has read them."""
        if done.notes:
            self.show(Message("note", done.saved(), remedy=" ".join(done.notes)))
        else:
            self.say(done.words())

    def say(self, words: str, milliseconds: int = SAID_MS) -> None:
        self._status.showMessage(words, milliseconds)
