"""Bars beside the timeline: where one is, how far the annotation is, what can be done."""

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtGui import QColor, QPalette
from PySide6.QtWidgets import QSizePolicy, QWidget

from ..forms.numbers import WholeNumberField
from ..style.building import hbox, label, menu_of, thin_progress, tool_button
from ..style.theme import current_theme


class Transport(QWidget):
    """A field for the frame's number with the recording's length and the time beside it."""

    def __init__(self) -> None:
        super().__init__()
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
        self._count, self._fps = count, fps
        with QSignalBlocker(self.number):
            self.number.setRange(0, max(count - 1, 0))
        self.setEnabled(count > 0)
        self._write()

    def set_frame(self, frame: int) -> None:
        with QSignalBlocker(self.number):
            self.number.setValue(frame)
        self._write()

    def type_frame(self) -> None:
        self.number.setFocus(Qt.FocusReason.ShortcutFocusReason)
        self.number.selectAll()

    def _write(self) -> None:
        minutes, rest = divmod(self.number.value() / self._fps, 60.0)
        time = f"{int(minutes)}:{rest:05.2f}" if minutes else f"{rest:.2f} s"
        self._length.setText(f"of 0 – {self._count - 1}   {time}" if self._count else "–")


class AnnotationBar(QWidget):
    """One row over the timeline."""

    def __init__(self) -> None:
        super().__init__()
        self.strip = thin_progress()
        self.strip.setRange(0, 1000)
        self.strip.setFixedSize(72, 6)
        self.progress = label(wraps=False)
        self.previous_button = tool_button(
            "Previous frame with a flag", "previous-failure", role="plain"
        )
        self.next_button = tool_button("Next frame with a flag", "next-failure", role="plain")
        self.selection_words = label("", "muted", wraps=False)
        self.selection_words.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self.selection_words.setAlignment(
            Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        )
        tip = "Actions on the selected frames"
        self.selection_button = tool_button(tip, "selection", "Selection ▾", "plain")
        self.selection_button.setAccessibleName(tip)
        self.selection_menu = menu_of(self.selection_button)
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
        colour = theme.good if share >= 1.0 else theme.accent
        colours.setColor(QPalette.ColorRole.Highlight, QColor(colour))
        self.strip.setPalette(colours)
        for button in (self.previous_button, self.next_button):
            button.setEnabled(flagged)

    def show_selection(self, words: str) -> None:
        self.selection_words.setText(words)
        self.selection_words.setToolTip(
            f"{words}\nCommands act on this selection. Drag in the ruler to select frames, "
            "Ctrl+click on names to select landmarks."
        )
