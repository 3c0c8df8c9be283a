"""Messages and failures reach the window: below the views, and in the status line."""

import sys
import threading
from collections.abc import Callable
from functools import partial
from types import TracebackType

from PySide6.QtCore import (
    QCoreApplication,
    QMessageLogContext,
    QObject,
    Qt,
    QtMsgType,
    Signal,
    Slot,
    qInstallMessageHandler,
)
from PySide6.QtWidgets import QStatusBar

from stereotrack_core.errors import InputError, visible

from ..session.messages import Message, Tell, message_of
from ..widgets.forms.message import MessageBar


def leave_out_noise() -> None:
    """Keep from the terminal what Qt's platform without a screen says about every window."""

    def handle(kind: QtMsgType, context: QMessageLogContext, words: str) -> None:
        if "does not support propagateSizeHints" in words:
            return
        if before is not None:
            before(kind, context, words)
        else:
            sys.stderr.write(f"{visible(words)}\n")

    before = qInstallMessageHandler(handle)


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
        threading.excepthook = self._on_thread_exception

    def remove(self) -> None:
        """Leave exceptions to whoever had them before; a second time does nothing."""
        sys.excepthook, threading.excepthook = self._before

    def _relay(self, error: BaseException) -> None:
        self._post.posted.emit(partial(self._tell, message_of(error)))

    def _on_exception(
        self, kind: type[BaseException], error: BaseException, trace: TracebackType | None
    ) -> None:
        if issubclass(kind, KeyboardInterrupt):
            sys.__excepthook__(kind, error, trace)
            return
        self._relay(error.with_traceback(trace))

    def _on_thread_exception(self, args: threading.ExceptHookArgs) -> None:
        if args.exc_value is not None and not isinstance(args.exc_value, SystemExit):
            self._relay(args.exc_value)


SAID_MS = 6000


class Notifier:
    """Messages below the views, and words in the status line."""

    def __init__(self, bar: MessageBar, status: QStatusBar) -> None:
        self._bar, self._status = bar, status
        self.dismissed = bar.dismissed

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

    def take_back(self, message: Message) -> None:
        self._bar.take_back(message)

    def clear(self) -> None:
        self._bar.clear()

    def say(self, words: str, milliseconds: int = SAID_MS) -> None:
        self._status.showMessage(words, milliseconds)
