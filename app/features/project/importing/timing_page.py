"""Second step: frame rate, and the unit of depth."""

from __future__ import annotations

from dataclasses import replace

from PySide6.QtCore import Slot
from PySide6.QtWidgets import QDoubleSpinBox, QFormLayout, QWizardPage

from stereotrack_core.recording.importing.choices import Choices, doubts_about

from ....widgets.forms.form_dialog import say_in
from ....widgets.style.building import label, vbox
from .looking import Looked

_WORDS = "Frame k of every source must show the same instant."


class TimingPage(QWizardPage):
    """Frames per second and metres per count."""

    def __init__(self, looked: Looked) -> None:
        super().__init__()
        self.setTitle("Timing")
        self._choices = looked.proposed
        self.fps = QDoubleSpinBox(minimum=0.0, maximum=1000.0, decimals=3)
        self.fps.setSpecialValueText("not known")
        self.fps.setAccessibleName("Frames per second")
        stated = looked.found.fps
        self.fps.setToolTip("Frame sets per second, as stated by the files")
        self.fps.setValue(stated or 0.0)
        self.unit = QDoubleSpinBox(minimum=0.01, maximum=1000.0, decimals=3, suffix=" mm")
        self.unit.setAccessibleName("Depth unit")
        self.unit.setToolTip("Millimetres per count of the depth maps")
        self.unit.setValue(1000.0 * looked.proposed.depth_unit)
        self.words = label()
        form = QFormLayout()
        form.addRow("&Frames per second", self.fps)
        deep = any(source.kind == "depth" for source in looked.found.sources)
        if deep:
            form.addRow("&Depth unit", self.unit)
            form.addRow("", label("Guessed from the depth of the scene. Check it.", "muted"))
        self.setLayout(vbox(label(_WORDS, "muted"), form, self.words, None))
        self.fps.valueChanged.connect(self._on_changed)

    def begin(self, choices: Choices) -> None:
        """Show what the sources that were chosen say about time."""
        self._choices = choices
        self._on_changed()

    def chosen(self, choices: Choices) -> Choices:
        """The choices with what is written here."""
        return replace(choices, fps=self.fps.value() or None, depth_unit=self.unit.value() / 1000.0)

    def isComplete(self) -> bool:
        return self.fps.value() > 0

    @Slot()
    def _on_changed(self) -> None:
        if not self.isComplete():
            say_in(self.words, "The files do not state their frame rate. Enter it.", error=True)
        else:
            doubts = doubts_about(self.chosen(self._choices))
            say_in(self.words, "\n".join(one for one in doubts if "frames off" in one))
        self.completeChanged.emit()
