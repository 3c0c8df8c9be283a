"""Where one is in the recording: the frame's number, how many there are, and the time."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import QSpinBox, QWidget

from ..style.building import hbox, label


class Transport(QWidget):
    """A field for the frame's number with the recording's length and the time beside it."""

    frame_requested = Signal(int)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.number = QSpinBox()
        self.number.setAccessibleName("Frame")
        self.number.setToolTip("Frame number, counted from 0")
        self.number.setKeyboardTracking(False)
        self.number.setButtonSymbols(QSpinBox.ButtonSymbols.NoButtons)
        self.number.setAlignment(Qt.AlignmentFlag.AlignRight)
        self.number.setFocusPolicy(Qt.FocusPolicy.ClickFocus)
        self.number.setMinimumWidth(56)
        self._length = label("", "muted", wraps=False)
        name = label("Frame", wraps=False)
        self.setLayout(hbox(name, self.number, self._length, margins=(4, 0, 4, 0)))
        self._fps = 1.0
        self._count = 0
        self.number.valueChanged.connect(self.frame_requested)
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
