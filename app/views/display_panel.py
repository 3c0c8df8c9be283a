"""Brightness and contrast of all views; the data stay as they are."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import QFormLayout, QLabel, QPushButton, QSlider, QWidget


class DisplayPanel(QWidget):
    """Two sliders and a way back.

    Signals
    -------
    changed : float, float
        Brightness (-1 to 1) and contrast (factor).
    """

    changed = Signal(float, float)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.brightness = _slider(-80, 80, "Brightness")
        self.contrast = _slider(-100, 100, "Contrast")
        self.reset_button = QPushButton("As recorded")
        form = QFormLayout(self)
        form.addRow("Brightness", self.brightness)
        form.addRow("Contrast", self.contrast)
        note = QLabel("For the display only: what is measured does not change.")
        note.setProperty("role", "muted")
        note.setWordWrap(True)
        form.addRow(note)
        form.addRow(self.reset_button)
        self.brightness.valueChanged.connect(self._tell)
        self.contrast.valueChanged.connect(self._tell)
        self.reset_button.clicked.connect(self.reset)

    def values(self) -> tuple[float, float]:
        """Brightness and contrast."""
        return self.brightness.value() / 100.0, 4.0 ** (self.contrast.value() / 100.0)

    def change(self, brightness: int = 0, contrast: int = 0) -> None:
        """Move the sliders by so many steps."""
        self.brightness.setValue(self.brightness.value() + brightness)
        self.contrast.setValue(self.contrast.value() + contrast)

    def reset(self) -> None:
        """Show the pictures as recorded."""
        with QSignalBlocker(self.brightness), QSignalBlocker(self.contrast):
            self.brightness.setValue(0)
            self.contrast.setValue(0)
        self._tell()

    def _tell(self, _value: int = 0) -> None:
        self.changed.emit(*self.values())


def _slider(low: int, high: int, name: str) -> QSlider:
    slider = QSlider(Qt.Orientation.Horizontal)
    slider.setRange(low, high)
    slider.setAccessibleName(name)
    slider.setMinimumWidth(120)
    return slider
