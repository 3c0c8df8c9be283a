"""What something has come to: a sentence first, remarks with what to do below it."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QSizePolicy, QWidget

from ..style.building import label, vbox
from ..style.theme import Dressed, current_theme

_MOST_REMARKS = 4


class VerdictBox(Dressed):
    """A raised box whose edge has the verdict's colour."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.setAccessibleName("Verdict")
        self._colour = "muted"
        self.words = label("", "heading")
        self.remarks = label()
        for one in (self.words, self.remarks):
            one.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Maximum)
        self.setLayout(vbox(self.words, self.remarks, margins=(12, 8, 12, 8), spacing=4))
        self._dress()

    def show_verdict(self, words: str, remarks: Sequence[str], colour: str) -> None:
        """Show a sentence and remarks; `colour` is the theme's: good, warning, error, muted."""
        shown = [f"• {one}" for one in remarks[:_MOST_REMARKS]]
        if len(remarks) > _MOST_REMARKS:
            shown.append(f"• and {len(remarks) - _MOST_REMARKS} more")
        self.words.setText(words)
        self.remarks.setText("\n".join(shown))
        self.remarks.setToolTip("\n".join(remarks))
        self.remarks.setVisible(bool(shown))
        self.setAccessibleDescription(" ".join((words, *remarks)))
        self._colour = colour
        self._dress()

    def _dress(self) -> None:
        theme = current_theme()
        sheet = (
            f"VerdictBox {{ background: {theme.raised}; border: none;"
            f" border-left: 5px solid {getattr(theme, self._colour)}; }}"
        )
        if sheet != self.styleSheet():
            self.setStyleSheet(sheet)
