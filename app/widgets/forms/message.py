"""What a message says."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from stereotrack_core.errors import visible


@dataclass(frozen=True)
class Message:
    """Something that the person should read."""

    severity: str
    """``error``, ``warning`` or ``note``."""
    what: str
    where: str = ""
    remedy: str = ""
    """`what`, `where` and `remedy`: what is wrong, where, and what to do about it; the last two may
    be empty."""
    button: str = ""
    """What can be done about it at once; empty: nothing."""
    do: Callable[[], None] | None = field(default=None, compare=False)
    """Does that."""

    def sentence(self) -> str:
        """Everything in one line, as plain text."""
        head = f"{self.where}: {self.what}" if self.where else self.what
        head = head if head.endswith((".", "!", "?")) else f"{head}."
        return visible(f"{head} {self.remedy}".strip())
