"""The user guide: what its page of the window says of the window's parts."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

CONTENTS = "index.md"
"""The page that leads to all others."""
WINDOW = "window.md"
"""The page whose table names the parts of the window, each with a link and a sentence or two."""

_PART = re.compile(r"^\| \[([^\]]+)\]\(([^)]+)\) \| (.+?) \|$", re.MULTILINE)
_MARKUP = re.compile(r"!?\[([^\]]*)\]\([^)]*\)|[*`|]")


@dataclass(frozen=True)
class Part:
    """A part of the window."""

    address: str
    """Page and heading that explain it, as a link names them."""
    about: str
    """Summary of the page."""


def anchor_of(heading: str) -> str:
    """What links call a heading: lower case, hyphens for spaces, no other signs."""
    plain = _MARKUP.sub(lambda found: found.group(1) or "", heading)
    return re.sub(r"[^\w\- ]", "", plain.lower()).strip().replace(" ", "-")


def parts_of(folder: Path) -> Mapping[str, Part]:
    """Parts of the window by their titles, as the guide in a folder explains them."""
    text = (folder / WINDOW).read_text(encoding="utf-8")
    return {
        title: Part(address if not address.startswith("#") else WINDOW + address, about)
        for title, address, about in _PART.findall(text)
    }
