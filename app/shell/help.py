"""The user guide in the window: its contents, and the page of a panel."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from PySide6.QtCore import QObject
from PySide6.QtGui import QCursor
from PySide6.QtWidgets import QApplication, QMainWindow, QWidget

from ..context import Context
from ..widgets.forms.help_panel import HelpPanel
from ..widgets.style.theme import data_folder

_PAGE = "help_page"
_WIDTH = 520

CONTENTS = "index.md"
"""The page that leads to all others."""
WINDOW = "window.md"
"""The page whose table names the parts of the window, each with a link and a sentence or two."""
_PART = re.compile(r"^\| \[([^\]]+)\]\(([^)]+)\) \| .+? \|$", re.MULTILINE)
_MARKUP = re.compile(r"!?\[([^\]]*)\]\([^)]*\)|[*`|]")


def anchor_of(heading: str) -> str:
    """What links call a heading: lower case, hyphens for spaces, no other signs."""
    plain = _MARKUP.sub(lambda found: found.group(1) or "", heading)
    return re.sub(r"[^\w\- ]", "", plain.lower()).strip().replace(" ", "-")


def _pages_of_parts(folder: Path) -> Mapping[str, str]:
    """Page and heading that explain each part of the window, by its title."""
    found = _PART.findall((folder / WINDOW).read_text(encoding="utf-8"))
    return {title: WINDOW + at if at.startswith("#") else at for title, at in found}


class Help(QObject):
    """Opens the user guide where it explains what the person is looking at."""

    def __init__(self, window: QMainWindow, context: Context) -> None:
        super().__init__(window)
        self._window, self._docks = window, context.docks
        self.panel = HelpPanel(data_folder("docs"), CONTENTS, anchor_of, window)

    def explain(self, others: Mapping[str, QWidget]) -> None:
        """Let every panel, and other parts of the window by name, know their page of the guide."""
        docks, pages = self._docks, _pages_of_parts(data_folder("docs"))
        titled = {title: docks.dock(name) for name, title in docks.titles().items()}
        for title, widget in {**titled, **others}.items():
            widget.setProperty(_PAGE, pages[title])

    def show_contents(self) -> None:
        """Open the guide at its contents."""
        self._show(CONTENTS)

    def show_for_panel(self) -> None:
        """Open the page of the panel under the cursor, or of the one with the focus."""
        under = _page_of(QApplication.widgetAt(QCursor.pos()))
        self._show(under or _page_of(self._window.focusWidget()) or CONTENTS)

    def _show(self, address: str) -> None:
        if self.panel.isHidden():
            inside = self._window.geometry()
            self.panel.resize(min(_WIDTH, inside.width() // 2), round(0.8 * inside.height()))
            self.panel.move(inside.right() - self.panel.width() - 24, inside.top() + 80)
        self.panel.show()
        self.panel.open(address)
        self.panel.raise_()
        self.panel.activateWindow()


def _page_of(widget: QWidget | None) -> str:
    """Where the guide explains a widget, or what it stands in; empty where nowhere."""
    while widget is not None:
        page = widget.property(_PAGE)
        if page:
            return str(page)
        widget = widget.parentWidget()
    return ""
