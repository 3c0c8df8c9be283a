"""The user guide: its pages, what stands in them, and where something is explained."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

CONTENTS = "index.md"
"""The page that leads to all others."""
WINDOW = "window.md"
"""The page whose table names the parts of the window, each with a link and a sentence or two."""

_PART = re.compile(r"^\| \[([^\]]+)\]\(([^)]+)\) \| (.+?) \|$", re.MULTILINE)

_HEADING = re.compile(r"^(#{1,6}) +(.+?) *$")
_MARKUP = re.compile(r"!?\[([^\]]*)\]\([^)]*\)|[*`|]|^[-#> ]+|^\|?[-: |]+\|$", re.MULTILINE)
_SNIPPET = 110
_IN_HEADING, _IN_PAGE_TITLE = 50, 20


@dataclass(frozen=True)
class Section:
    """A part of a page under one heading."""

    page: str
    """Name of its file."""
    page_title: str
    heading: str
    anchor: str
    """As in links to it."""
    text: str
    """What stands in it, without markup."""

    @property
    def address(self) -> str:
        """Page and anchor, as a link names them."""
        return f"{self.page}#{self.anchor}"


@dataclass(frozen=True)
class Hit:
    """A section in which something was found."""

    address: str
    title: str
    """Page and heading, as a person reads them."""
    snippet: str
    """Words around the first place."""


def anchor_of(heading: str) -> str:
    """What links call a heading: lower case, hyphens for spaces, no other signs."""
    plain = re.sub(r"[^\w\- ]", "", _plain(heading).lower())
    return plain.strip().replace(" ", "-")


def _plain(text: str) -> str:
    def kept(found: re.Match[str]) -> str:
        return found.group(1) or ("" if found.group() in "*`" else " ")

    return _MARKUP.sub(kept, text)


class Guide:
    """Pages in Markdown in a folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    @cached_property
    def sections(self) -> tuple[Section, ...]:
        """All sections; the pages in the order of the contents page."""
        contents = (self.folder / CONTENTS).read_text(encoding="utf-8")
        linked = re.findall(r"\]\(([\w-]+\.md)", contents)
        every = [CONTENTS, *linked, *sorted(path.name for path in self.folder.glob("*.md"))]
        return tuple(part for name in dict.fromkeys(every) for part in self._of_page(name))

    def _of_page(self, name: str) -> Iterator[Section]:
        title, heading, lines, fenced = "", "", [], False
        for line in [*(self.folder / name).read_text(encoding="utf-8").splitlines(), None]:
            fenced ^= line is not None and line.startswith("```")
            found = None if line is None or fenced else _HEADING.match(line)
            if line is not None and found is None:
                lines.append(line)
                continue
            if heading:
                text = " ".join(_plain("\n".join(lines)).split())
                yield Section(name, title, heading, anchor_of(heading), text)
            heading = _plain(found.group(2)).strip() if found else ""
            title, lines = title or heading, []

    @cached_property
    def parts(self) -> Mapping[str, Hit]:
        """What the page of the window says of its parts: where more is said, and in short."""
        text = (self.folder / WINDOW).read_text(encoding="utf-8")
        return {
            title: Hit(address if not address.startswith("#") else WINDOW + address, title, about)
            for title, address, about in _PART.findall(text)
        }

    def search(self, words: str, most: int = 40) -> list[Hit]:
        """Sections that contain all words (or their beginnings); headings count most."""
        wanted = words.lower().split()
        ranked = []
        for place, section in enumerate(self.sections):
            heading, title = section.heading.lower(), section.page_title.lower()
            text = section.text.lower()
            if wanted and all(word in f"{title} {heading} {text}" for word in wanted):
                score = sum(
                    _IN_HEADING * _begins(word, heading)
                    + _IN_PAGE_TITLE * _begins(word, title)
                    + min(text.count(word), 10)
                    for word in wanted
                )
                ranked.append((-score, place))
        return [_hit(self.sections[place], wanted) for _, place in sorted(ranked)[:most]]


def _begins(word: str, text: str) -> bool:
    return any(each.startswith(word) for each in re.findall(r"\w+", text))


def _hit(section: Section, wanted: list[str]) -> Hit:
    """What the list of results says about a section."""
    places = [section.text.lower().find(word) for word in wanted]
    start = max(min((at for at in places if at >= 0), default=0) - 30, 0)
    start = section.text.rfind(" ", 0, start) + 1
    cut = section.text[start : start + _SNIPPET]
    snippet = f"{'… ' if start else ''}{cut}{' …' if start + _SNIPPET < len(section.text) else ''}"
    same = section.heading == section.page_title
    title = section.heading if same else f"{section.page_title} › {section.heading}"
    return Hit(section.address, title, snippet)
