"""Bars beside the timeline: where one is, how far the annotation is, what can be done."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QPoint, QSignalBlocker, Qt
from PySide6.QtGui import QAction, QColor, QPalette
from PySide6.QtWidgets import QMenu, QSizePolicy, QToolButton, QWidget

from ..forms.numbers import WholeNumberField
from ..style.building import hbox, label, thin_progress, tool_button
from ..style.theme import current_theme


class Transport(QWidget):
    """A field for the frame's number with the recording's length and the time beside it."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.number = WholeNumberField()
        self.number.setAccessibleName("Frame")
        self.number.setToolTip("Frame number, counted from 0")
        self.number.setKeyboardTracking(False)
        self.number.setButtonSymbols(WholeNumberField.ButtonSymbols.NoButtons)
        self.number.setAlignment(Qt.AlignmentFlag.AlignRight)
        self.number.setFocusPolicy(Qt.FocusPolicy.ClickFocus)
        self.number.setMinimumWidth(56)
        self._length = label("", "muted", wraps=False)
        name = label("Frame", wraps=False)
        self.setLayout(hbox(name, self.number, self._length, margins=(4, 0, 4, 0)))
        self._fps = 1.0
        self._count = 0
        self.number.editingFinished.connect(self.number.clearFocus)
        self.set_range(0, 1.0)

    def set_range(self, count: int, fps: float) -> None:
        """Tell how many frames there are, and how many a second."""
        self._count, self._fps = count, fps
        with QSignalBlocker(self.number):
            self.number.setRange(0, max(count - 1, 0))
        self.setEnabled(count > 0)
        self._write()

    def set_frame(self, frame: int) -> None:
        """Show where one is."""
        with QSignalBlocker(self.number):
            self.number.setValue(frame)
        self._write()

    def type_frame(self) -> None:
        """Let the person type a number."""
        self.number.setFocus(Qt.FocusReason.ShortcutFocusReason)
        self.number.selectAll()

    def _write(self) -> None:
        seconds = self.number.value() / self._fps
        last = max(self._count - 1, 0)
        minutes, rest = divmod(seconds, 60.0)
        time = f"{int(minutes)}:{rest:05.2f}" if minutes else f"{rest:.2f} s"
        self._length.setText(f"of 0 – {last}   {time}" if self._count else "–")


class AnnotationBar(QWidget):
    """One row over the timeline."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.strip = thin_progress()
        self.strip.setRange(0, 1000)
        self.strip.setFixedSize(72, 6)
        self.progress = label(wraps=False)
        self.previous_button = _button("previous-failure", "Previous frame with a flag")
        self.next_button = _button("next-failure", "Next frame with a flag")
        self.selection_words = label("", "muted", wraps=False)
        self.selection_words.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self.selection_words.setAlignment(
            Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        )
        self.selection_button = _button("selection", "Actions on the selected frames", "Selection")
        self.selection_menu = self.selection_button.menu()
        self.selection_menu.setToolTipsVisible(True)
        left = (self.strip, self.progress, self.previous_button, self.next_button)
        right = ((self.selection_words, 1), self.selection_button)
        self.setLayout(hbox(*left, *right, margins=(8, 1, 8, 1), spacing=6))
        self.setAccessibleName("Annotation")
        self.hide()

    def show_progress(self, words: str, share: float, *, flagged: bool) -> None:
        """Say how far the annotation is; `share` is that of the keyframes that are done."""
        self.progress.setText(words)
        self.strip.setValue(round(1000 * share))
        colours, theme = self.strip.palette(), current_theme()
        colours.setColor(
            QPalette.ColorRole.Highlight, QColor(theme.good if share >= 1.0 else theme.accent)
        )
        self.strip.setPalette(colours)
        self.previous_button.setEnabled(flagged)
        self.next_button.setEnabled(flagged)

    def show_selection(self, words: str) -> None:
        """Say what commands work on."""
        self.selection_words.setText(words)
        self.selection_words.setToolTip(
            f"{words}\nCommands act on this selection. Drag in the ruler to select frames, "
            "Ctrl+click on names to select landmarks."
        )

    def set_selection_actions(self, actions: Sequence[QAction | None]) -> None:
        """Offer these commands on the selection; None separates."""
        self.selection_menu.clear()
        for action in actions:
            if action is None:
                self.selection_menu.addSeparator()
            else:
                self.selection_menu.addAction(action)

    def show_selection_menu(self, place: QPoint) -> None:
        """Offer the commands on the selection at a place of the screen."""
        self.selection_menu.popup(place)


def _button(icon: str, tip: str, menu: str = "") -> QToolButton:
    """Make a button; with a name for its menu it opens that."""
    button = tool_button(tip, icon, f"{menu} ▾" if menu else "", role="plain")
    button.setAccessibleName(tip)
    if menu:
        button.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        button.setMenu(QMenu(button))
    return button
