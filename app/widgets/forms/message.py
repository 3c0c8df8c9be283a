"""What a message says."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from stereotrack_core.errors import visible


@dataclass(frozen=True)
class Message:
    """Something that the person should read.

    Attributes
    ----------
    severity : str
        ``error``, ``warning`` or ``note``.
    what, where, remedy : str
        What is wrong, where, and what to do about it; the last two may be empty.
    button : str
        What can be done about it at once; empty: nothing.
    do : callable or None
        Does that.
    """

    severity: str
    what: str
    where: str = ""
    remedy: str = ""
    button: str = ""
    do: Callable[[], None] | None = field(default=None, compare=False)

    def sentence(self) -> str:
        """Everything in one line, as plain text."""
        head = f"{self.where}: {self.what}" if self.where else self.what
        head = head if head.endswith((".", "!", "?")) else f"{head}."
        return visible(f"{head} {self.remedy}".strip())
