"""What happens when something fails: a sentence for the person, the details in a log file."""

import logging
import sys
import threading
from collections.abc import Callable
from logging.handlers import RotatingFileHandler
from pathlib import Path
from types import TracebackType
from typing import TypeAlias

import platformdirs
from PySide6.QtCore import (
    QMessageLogContext,
    QObject,
    QtMsgType,
    Signal,
    Slot,
    qInstallMessageHandler,
)
from PySide6.QtWidgets import QStatusBar

from stereotrack_core.errors import InputError, visible
from stereotrack_core.worker_processes import Lost

from ..widgets.forms.message import Message, MessageBar

LOG = logging.getLogger("stereotrack")
Tell: TypeAlias = Callable[[Message], object]
_LOST = "Try again. If it happens again, free memory by closing other programs."


def log_path() -> Path:
    """File that details of failures are written to."""
    return Path(platformdirs.user_log_dir("stereotrack", appauthor=False)) / "stereotrack.log"


def open_log() -> None:
    """Write the log to :func:`log_path`; without a writable folder the program runs without."""
    path = log_path()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handler = RotatingFileHandler(path, maxBytes=1_000_000, backupCount=2, encoding="utf-8")
    except OSError:
        return
    logging.raiseExceptions = False  # where the drive is full, nobody is bothered with that
    handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(message)s"))
    LOG.addHandler(handler)
    LOG.setLevel(logging.INFO)


def message_of(error: BaseException) -> Message:
    """Say an exception in words; one that is not the user's doing is logged with its traceback."""
    if isinstance(error, InputError):
        return Message("error", error.what, error.where, error.remedy)
    if isinstance(error, OSError) and error.strerror:
        return Message("error", error.strerror, str(error.filename or ""))
    if isinstance(error, Lost):
        return Message("error", str(error), remedy=_LOST)
    LOG.error("unexpected", exc_info=(type(error), error, error.__traceback__))
    words = str(error).strip().splitlines()
    detail = f"{type(error).__name__}: {words[0]}" if words else type(error).__name__
    return Message(
        "error",
        f"Unexpected error in the program ({detail})",
        remedy=f"Your data are safe. Details are in {log_path()}.",
    )


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


class FailureRelay(QObject):
    """Tells exceptions that nobody caught, of any thread, as messages in the window's thread."""

    _message = Signal(object)

    def __init__(self, tell: Tell) -> None:
        super().__init__()
        self._tell_message = tell
        self._message.connect(self._on_message)
        self._before = sys.excepthook, threading.excepthook
        sys.excepthook = self._on_exception
        threading.excepthook = self._on_thread_exception

    def remove(self) -> None:
        """Leave exceptions to whoever had them before; a second time does nothing."""
        sys.excepthook, threading.excepthook = self._before

    @Slot(object)
    def _on_message(self, message: Message) -> None:
        self._tell_message(message)

    def _on_exception(
        self, kind: type[BaseException], error: BaseException, trace: TracebackType | None
    ) -> None:
        if issubclass(kind, KeyboardInterrupt):
            sys.__excepthook__(kind, error, trace)
            return
        self._message.emit(message_of(error.with_traceback(trace)))

    def _on_thread_exception(self, args: threading.ExceptHookArgs) -> None:
        if args.exc_value is not None and not isinstance(args.exc_value, SystemExit):
            self._message.emit(message_of(args.exc_value))


SAID_MS = 6000


class Notifier:
    """Messages over the views, and words in the status line."""

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
