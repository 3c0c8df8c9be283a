"""Numbers as a person types them, and with their words."""

import re

_NUMBER = re.compile(r"[+-]?([0-9]+[.,]?[0-9]*|[.,][0-9]+)([eE][+-]?[0-9]+)?")
_WHOLE = re.compile(r"[+-]?[0-9]+")


def typed_number(text: str) -> float:
    """Read a number as a person types it: ``.`` and ``,`` are both the decimal sign.

    Raises ValueError for everything else. ``1.234,5`` and ``1 234`` are not guessed at.
    """
    return float(_matched(_NUMBER, text).replace(",", "."))


def typed_whole_number(text: str) -> int:
    """Read a whole number as a person types it; ValueError for everything but digits."""
    return int(_matched(_WHOLE, text))


def _matched(form: re.Pattern[str], text: str) -> str:
    typed = text.strip().replace("\N{MINUS SIGN}", "-")
    if not form.fullmatch(typed):
        raise ValueError(f"{text!r} is not a number")
    return typed


def counted(number: int, word: str) -> str:
    """``1 click``, ``2 clicks``."""
    return f"{number:,} {word}{'' if number == 1 else 's'}".replace(",", " ")


def frames_in_words(frames: range) -> str:
    """``frame 12``, or ``frames 12 – 40``; a range without steps that is not empty."""
    if len(frames) == 1:
        return f"frame {frames.start}"
    return f"frames {frames.start} – {frames.stop - 1}"


UNKNOWN_DEG = 45.0  # standard deviation of a limb's direction from which it says nothing


def spread_words(degrees: float, unit: str = "°", digits: int = 1) -> str:
    """A standard deviation of a limb's direction: ``4.3°``, or ``unknown``."""
    return f"{degrees:.{digits}f}{unit}" if degrees <= UNKNOWN_DEG else "unknown"


def in_words(seconds: float) -> str:
    """A stretch of time: ``under a second``, ``40 s``, ``12 min``, ``3.5 h``, ``2.1 days``."""
    if seconds < 1.0:
        return "under a second"
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    if seconds < 90.0 * 60.0:
        return f"{seconds / 60.0:.0f} min"
    hours = seconds / 3600.0
    return f"{hours:.1f} h" if hours < 48.0 else f"{hours / 24.0:.1f} days"
