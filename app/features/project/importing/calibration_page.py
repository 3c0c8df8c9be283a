"""Third step: the calibration of the cameras, or a guess."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from PySide6.QtCore import QSignalBlocker, Slot
from PySide6.QtWidgets import QComboBox, QFormLayout, QRadioButton, QWidget, QWizardPage

from stereotrack_core.errors import InputError
from stereotrack_core.recording.calibration import read_calibration
from stereotrack_core.recording.importing.choices import GUESS, Choices
from stereotrack_core.recording.importing.making import cameras_for

from ....widgets.forms.form_dialog import ask_to_open, line_edit, push_button, say_in
from ....widgets.style.building import choice, hbox, label, scrolled, vbox
from .looking import Looked


class CalibrationPage(QWizardPage):
    """A calibration.toml with the camera of each source, or cameras guessed from the images."""

    def __init__(self, looked: Looked) -> None:
        super().__init__()
        self.setTitle("Calibration")
        self._choices = looked.proposed
        self._folder = str(looked.found.folder or "")
        self.from_file = QRadioButton("Calibration &file (calibration.toml)")
        self.from_file.setToolTip("Layout of aniposelib and Pose2Sim, with the unit in [metadata]")
        self.guess = QRadioButton("&Guess the cameras from the image size (no calibration yet)")
        self.guess.setToolTip("For viewing and clicking; calibrate later")
        given = looked.proposed.calibration
        self.path = line_edit("Calibration file", str(given or ""), "calibration.toml")
        self.browse = push_button("&Choose …", self._ask, "Choose a calibration file")
        self.words = label()
        self._cameras: dict[str, QComboBox] = {}
        self._form = QFormLayout()
        inside = QWidget()
        inside.setLayout(self._form)
        self._area = scrolled(inside, "Cameras")
        file_row = hbox((self.path, 1), self.browse, margins=(24, 0, 0, 0))
        self.setLayout(
            vbox(
                self.from_file, file_row, (self._area, 1),
                self.guess, label(GUESS, "muted", margins=(24, 0, 0, 0)),
                self.words, None,
            )
        )  # fmt: skip
        (self.guess if given is None else self.from_file).setChecked(True)
        self.guess.toggled.connect(self._on_changed)
        self.path.textChanged.connect(self._on_changed)

    def begin(self, choices: Choices) -> None:
        """Ask for the cameras of the sources that were chosen."""
        self._choices = choices
        self._on_changed()

    def chosen(self, choices: Choices) -> Choices:
        """The choices with what is written here."""
        if self.guess.isChecked():
            return replace(choices, calibration=None, cameras={})
        cameras = {name: box.currentData() for name, box in self._cameras.items()}
        path = Path(self.path.text().strip())
        return replace(choices, calibration=path, cameras=cameras)

    def isComplete(self) -> bool:
        return not self._problem()

    def _problem(self) -> str:
        if not self.guess.isChecked() and not self.path.text().strip():
            return "Choose a calibration file."
        try:
            cameras_for(self.chosen(self._choices))
        except InputError as error:
            return str(error)
        return ""

    def _ask(self) -> None:
        def use(path: Path) -> None:
            self.from_file.setChecked(True)
            self.path.setText(str(path))

        ask_to_open(self, "Choose a calibration", self._folder, "Calibration (*.toml)", use)

    @Slot()
    def _on_changed(self) -> None:
        for field in (self.path, self.browse):
            field.setEnabled(self.from_file.isChecked())
        self._list_cameras()
        self._area.setVisible(bool(self._cameras))
        self._check()

    def _list_cameras(self) -> None:
        """A field for each camera here: which of the file's cameras it is."""
        before = {name: box.currentData() for name, box in self._cameras.items()}
        while self._form.rowCount():
            self._form.removeRow(0)
        self._cameras.clear()
        if self.guess.isChecked() or not self.path.text().strip():
            return
        try:
            known = list(read_calibration(Path(self.path.text().strip())))
        except InputError:
            return  # it is said below
        for name in self._choices.camera_names():
            options = [("", "choose"), *((one, one) for one in known)]
            box = choice(f"Camera of {name}", options, f"Which camera of the file {name} is")
            with QSignalBlocker(box):
                wanted = before.get(name) or next(
                    (one for one in known if one.casefold() == name.casefold()), ""
                )
                box.setCurrentIndex(max(box.findData(wanted), 0))
            box.currentIndexChanged.connect(self._check)
            self._form.addRow(name, box)
            self._cameras[name] = box

    @Slot()
    def _check(self) -> None:
        problem = self._problem()
        unsaid = [name for name, box in self._cameras.items() if not box.currentData()]
        if unsaid and problem:
            problem = f"Say which camera of the file is {' and which is '.join(unsaid)}."
        say_in(self.words, problem, error=True)
        self.completeChanged.emit()
