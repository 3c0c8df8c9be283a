"""Says that the frame is annotated again, blindly."""

from __future__ import annotations

from PySide6.QtCore import QEvent, Signal
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QPushButton, QSizePolicy, QWidget

from ..style.theme import current_theme


class RepeatBar(QFrame):
    """A bar over the views while the first reading of a frame is hidden.

    Signals
    -------
    finish_requested : ()
    """

    finish_requested = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.words = QLabel()
        self.words.setWordWrap(True)
        self.words.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        self.finish_button = QPushButton("Finish and show")
        self.finish_button.setToolTip(
            "Finish the blind repeat; both passes are kept in the project"
        )
        self.finish_button.clicked.connect(self.finish_requested)
        row = QHBoxLayout(self)
        row.setContentsMargins(8, 4, 8, 4)
        row.addWidget(self.words, 1)
        row.addWidget(self.finish_button)
        self.setAccessibleName("Blind repeat")
        self._dress()
        self.hide()

    def show_words(self, words: str) -> None:
        """Say this; nothing to say hides the bar."""
        self.words.setText(words)
        self.setVisible(bool(words))

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange:
            self._dress()

    def _dress(self) -> None:
        theme = current_theme()
        sheet = (
            f"RepeatBar {{ background: {theme.raised}; border: none;"
            f" border-left: 4px solid {theme.accent}; border-bottom: 1px solid {theme.border}; }}"
        )
        if sheet != self.styleSheet():
            self.setStyleSheet(sheet)
