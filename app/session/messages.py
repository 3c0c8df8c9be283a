"""Messages to the person, and the event loop and preferences that the session is given."""

import logging
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from logging.handlers import RotatingFileHandler
from pathlib import Path
from typing import Any, Protocol, TypeAlias, overload

import platformdirs

from stereotrack_core.errors import InputError, visible
from stereotrack_core.worker_processes import Lost

LOG = logging.getLogger("stereotrack")
_LOST = "Try again. If it happens again, free memory by closing other programs."


@dataclass(frozen=True)
class Message:
    """A message to the person."""

    severity: str  # `error`, `warning` or `note`
    what: str
    where: str = ""
    remedy: str = ""
    """`what`, `where` and `remedy`: what is wrong, where, and what to do about it; the last two may
    be empty."""
    button: str = ""  # what can be done about it at once; empty: nothing
    do: Callable[[], None] | None = field(default=None, compare=False)
    others: tuple[tuple[str, Callable[[], None]], ...] = field(default=(), compare=False)
    """Further buttons and what each does."""

    def sentence(self) -> str:
        head = f"{self.where}: {self.what}" if self.where else self.what
        head = head if head.endswith((".", "!", "?")) else f"{head}."
        return visible(f"{head} {self.remedy}".strip())


Tell: TypeAlias = Callable[[Message], object]


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


class Timer(Protocol):
    """Calls a function once, so long after it was started last."""

    @overload
    def start(self, /) -> None: ...

    @overload
    def start(self, msec: int, /) -> None: ...

    def stop(self) -> None:
        """Do not call it."""

    def isActive(self) -> bool:
        """Whether it will be called."""


@dataclass(frozen=True)
class Loop:
    """The loop that runs in the window's thread."""

    post: Callable[[Callable[[], object]], object]
    """Have a function called there, when everything that happens now has happened; any thread."""
    later: Callable[[Callable[[], object], int], Timer]
    """Make a timer of a function and milliseconds."""
    is_alive: Callable[[Callable[..., object]], bool] = lambda _do: True
    """Whether a function can be called: it is no method of a widget that is gone."""

    def call(self, do: Callable[..., object], *news: object) -> None:
        """Call a function if it can be; what it raises is shown, and keeps nothing else back."""
        try:
            if self.is_alive(do):
                do(*news)
        except Exception:  # noqa: BLE001 - the window shows it
            sys.excepthook(*sys.exc_info())


class Preferences(Protocol):
    """Preferences for the next start, apart from all data."""

    def value(self, key: str, /) -> Any:
        """The value of a key, None without one."""

    def setValue(self, key: str, value: Any, /) -> None:
        """Keep a value."""


def stored_text(kept: Preferences, key: str) -> str:
    """A text; empty where there is none."""
    value = kept.value(key)
    return value if isinstance(value, str) else ""


def stored_texts(kept: Preferences, key: str) -> list[str] | None:
    """Texts; None where there are none. A single one comes back from the file by itself."""
    value = kept.value(key)
    texts = [value] if isinstance(value, str) else value
    return [text for text in texts if isinstance(text, str)] if isinstance(texts, list) else None
