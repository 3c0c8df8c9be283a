"""What the session is handed by whoever shows it: the window's thread, and what is kept."""

import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, overload


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
    """What is kept for the next start, apart from all data."""

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
