"""The last step: where the calibration goes."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtWidgets import QWidget

from stereotrack_core.calibrate.changes import change_table, place_table

from ....widgets.forms.form_dialog import ask_to_save, push_button
from ....widgets.style.building import hbox, label, vbox
from ....widgets.tables.plain import PlainTable
from ..controller import CalibrationController
from ..saving import why_not_into
from ..state import Calibration


class SavePage(QWidget):
    """Before and after, and where the calibration goes."""

    def __init__(self, calibration: CalibrationController) -> None:
        super().__init__()
        self._calibration = calibration
        self.changes, self.places = PlainTable("Before and after"), PlainTable("The world")
        self.about = label("", "muted")
        self.file_button = push_button(
            "&Save calibration …", self.ask, "Write a calibration.toml, and a report beside it"
        )
        self.into_button = push_button(
            "Save into the &recording", calibration.save_into_recording,
            "Replace the calibration of the open recording; the one before is kept beside it",
        )  # fmt: skip
        self.why_not = label("", "muted")
        words = (
            "The calibration holds the lens and the place of every camera. The report beside it is "
            "a page with the verdict and all tables."
        )
        self.another_world = label("", "muted")
        buttons = hbox(self.file_button, self.into_button, None)
        self.setLayout(
            vbox(self.changes, self.about, self.places, self.another_world, label(words, "muted"),
                 buttons, self.why_not, None, spacing=10)
        )  # fmt: skip

    def show_state(self, state: Calibration) -> None:
        """Show what the new calibration changes."""
        self.changes.show_table(change_table(state.changes) if state.changes else None)
        self.about.setVisible(bool(state.changes))
        self.about.setText(
            "Before: the cameras of the open recording, with the boards placed as well as they "
            "allow. The two calibrations are laid over each other by all cameras."
        )
        turned = state.alignment is not None and bool(state.cameras)
        self.places.show_table(place_table(state.base, state.cameras) if turned else None)
        self.another_world.setVisible(turned and state.axes.way != "recording")
        self.another_world.setText(
            "Runs, references and landmarks in space stay in the world before. After saving into "
            "the recording, track again; clicks in the images stay right."
        )
        why_not = why_not_into(state)
        self.into_button.setVisible(state.recording is not None)
        self.into_button.setEnabled(not why_not)
        self.why_not.setVisible(state.recording is not None and bool(why_not))
        self.why_not.setText(f"It cannot be saved into the recording. {why_not}")

    def ask(self) -> None:
        """Ask for a file, and write it."""
        state = self._calibration.state
        start = Path(state.sources[0].place).parent if state.sources else Path.home()
        if state.recording is not None and not state.sources:
            start = state.recording.folder.parent
        ask_to_save(
            self, "Save the calibration", start / "calibration.toml", "Calibration (*.toml)",
            self._calibration.save,
        )  # fmt: skip
