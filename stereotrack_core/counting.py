"""Numbers with their words."""

from __future__ import annotations


def counted(number: int, word: str) -> str:
    """``1 click``, ``2 clicks``."""
    return f"{number:,} {word}{'' if number == 1 else 's'}".replace(",", " ")


def frames_in_words(frames: range) -> str:
    """``frame 12``, or ``frames 12 – 40``; a range without steps that is not empty."""
    if len(frames) == 1:
        return f"frame {frames.start}"
    return f"frames {frames.start} – {frames.stop - 1}"
