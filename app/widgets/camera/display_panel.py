"""Brightness and contrast of all views or of one; the data stay as they are."""

from collections.abc import Callable
from math import log

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtWidgets import QCheckBox, QFormLayout, QPushButton, QSlider, QWidget

from ..style.building import label


class DisplayPanel(QWidget):
    """Two sliders and a way back, for all views or for the active one.

    `change_light` is called with brightness (-1 to 1) and contrast (factor).
    """

    def __init__(self, change_light: Callable[[float, float], object]) -> None:
        super().__init__()
        self._change_light = change_light
        self.brightness = _slider(-80, 80, "Brightness")
        self.contrast = _slider(-100, 100, "Contrast")
        self.reset_button = QPushButton("Reset brightness and contrast")
        self.only_this = QCheckBox("Active view only")
        self._active = ""
        form = QFormLayout(self)
        form.addRow(self.only_this)
        form.addRow("Brightness", self.brightness)
        form.addRow("Contrast", self.contrast)
        form.addRow(label("Affects the display only; measurements do not change.", "muted"))
        form.addRow(self.reset_button)
        for slider in (self.brightness, self.contrast):
            slider.valueChanged.connect(self._tell)
        self.reset_button.clicked.connect(self.reset)

    @property
    def view(self) -> str:
        """The view that the sliders are for; empty: all of them."""
        return self._active if self.only_this.isChecked() else ""

    def show_light(self, view: str, brightness: float, contrast: float) -> None:
        self._active = view
        self.only_this.setText(f"Only view {view}" if view else "Active view only")
        with QSignalBlocker(self.brightness), QSignalBlocker(self.contrast):
            self.brightness.setValue(round(100.0 * brightness))
            self.contrast.setValue(round(100.0 * log(contrast, 4.0)))

    def change(self, brightness: int = 0, contrast: int = 0) -> None:
        self.brightness.setValue(self.brightness.value() + brightness)
        self.contrast.setValue(self.contrast.value() + contrast)

    def reset(self) -> None:
        with QSignalBlocker(self.brightness), QSignalBlocker(self.contrast):
            self.brightness.setValue(0)
            self.contrast.setValue(0)
        self._tell()

    def _tell(self) -> None:
        brightness, contrast = self.brightness.value() / 100.0, self.contrast.value() / 100.0
        self._change_light(brightness, 4.0**contrast)


def _slider(low: int, high: int, name: str) -> QSlider:
    slider = QSlider(Qt.Orientation.Horizontal)
    slider.setRange(low, high)
    slider.setAccessibleName(name)
    slider.setMinimumWidth(120)
    return slider
