"""Messages to the person, and failures as messages with their details in a log file."""

import logging
from collections.abc import Callable
from dataclasses import dataclass, field
from logging.handlers import RotatingFileHandler
from pathlib import Path
from typing import TypeAlias

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
