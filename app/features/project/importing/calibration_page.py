"""Third step, and a dialog of its own: a calibration of any tool, or guessed cameras."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

from PySide6.QtCore import QSignalBlocker
from PySide6.QtWidgets import QComboBox, QFormLayout, QRadioButton, QWidget, QWizardPage

from stereotrack_core.errors import InputError
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.interop.calibrations.deciding import (
    CONVENTIONS,
    MEANINGS,
    Decided,
    Undecided,
    with_calibration,
)
from stereotrack_core.interop.calibrations.foreign import METRES_PER_UNIT
from stereotrack_core.recording.calibration import read_calibration
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.importing.choices import GUESS, Choices, Source, Use
from stereotrack_core.recording.importing.making import cameras_for

from ....context import Context
from ....session.replacing import replace_cameras
from ....widgets.forms.form_dialog import FormDialog, ask_to_open, line_edit, push_button, say_in
from ....widgets.style.building import choice, hbox, holder, label, scrolled, vbox

FILES = "Calibrations (*.toml *.yml *.yaml *.xml *.json *.mat *.txt *.conf)"


class CalibrationPage(QWizardPage):
    """A file with the camera of each source and how it is read, or guessed cameras."""

    def __init__(self, proposed: Choices, folder: Path | None) -> None:
        super().__init__()
        self.setTitle("Calibration")
        self._choices = proposed
        self._folder = str(folder or "")
        self._read: Choices | None = None
        self._decided: Decided | None = None
        self._complaint = ""
        self._make_fields(proposed.calibration)
        self._form, reading = QFormLayout(), QFormLayout()
        self._area = scrolled(holder(self._form), "Cameras")
        file_row = hbox((self.path, 1), self.browse, margins=(24, 0, 0, 0))
        reading.setContentsMargins(24, 0, 0, 0)
        reading.addRow("&Unit of its lengths", self.unit)
        reading.addRow("Con&vention", self.convention)
        self.how = holder(reading)
        self.about_guess = label(GUESS, "muted", margins=(24, 0, 0, 0))
        parts = (self.from_file, file_row, self.how, (self._area, 1), self.guess, self.about_guess)
        self.setLayout(vbox(*parts, self.words, None))
        (self.guess if proposed.calibration is None else self.from_file).setChecked(True)
        self.guess.toggled.connect(self._on_changed)
        self.path.textChanged.connect(self._on_changed)
        for box in (self.unit, self.convention):
            box.currentIndexChanged.connect(self._on_changed)

    def _make_fields(self, given: Path | None) -> None:
        self.from_file = QRadioButton("Calibration &file")
        self.from_file.setToolTip(
            "A calibration.toml, or a file of aniposelib, FreeMoCap, Pose2Sim, caliscope, OpenCV, "
            "ROS, Qualisys, MATLAB or ZED"
        )
        self.guess = QRadioButton("&Guess the cameras from the image size (no calibration yet)")
        self.guess.setToolTip("For viewing and clicking; calibrate later")
        self.path = line_edit(
            "Calibration file", str(given or ""), "calibration.toml",
            tip="Several files that belong together are separated by ;",
        )  # fmt: skip
        self.browse = push_button("&Choose …", self._ask, "Choose a calibration file")
        units = [("", "as the file says"), *((unit, unit) for unit in METRES_PER_UNIT)]
        self.unit = choice("Unit of its lengths", units, "Unit of the lengths in the file")
        meanings = [(name, f"{name}: {MEANINGS[name]}") for name in CONVENTIONS]
        self.convention = choice(
            "Convention", [("", "as the format documents it"), *meanings],
            "How rotation R and translation t of the file map",
        )  # fmt: skip
        self.words = label()
        self._cameras: dict[str, QComboBox] = {}

    def use_file(self, path: Path) -> bool:
        """Use a file and offer no guess; False where cameras are taken in its order."""
        for one in (self.guess, self.about_guess):
            one.hide()
        self.from_file.setChecked(True)
        self.path.setText(str(path))
        boxes = [*self._cameras.values()]
        if any(box.currentData() or box.count() != len(boxes) + 1 for box in boxes):
            return True
        for place, box in enumerate(boxes, start=1):
            box.setCurrentIndex(place)
        return not boxes

    def begin(self, choices: Choices) -> None:
        self._choices = choices
        self._on_changed()

    def chosen(self, choices: Choices) -> Choices:
        if self.guess.isChecked():
            return replace(choices, calibration=None, given=None, cameras={})
        if (read := self._read) is None:
            return choices
        cameras = {name: box.currentData() for name, box in self._cameras.items()}
        return replace(choices, calibration=read.calibration, given=read.given, cameras=cameras)

    def isComplete(self) -> bool:
        return not self._problem()

    def _problem(self) -> str:
        if self.guess.isChecked():
            return ""
        if not self._paths() or self._complaint:
            return self._complaint or "Choose a calibration file."
        try:
            cameras_for(self.chosen(self._choices))
        except InputError as error:
            return str(error)
        return ""

    def _paths(self) -> list[Path]:
        return [Path(one.strip()) for one in self.path.text().split(";") if one.strip()]

    def _ask(self) -> None:
        def use(path: Path) -> None:
            self.from_file.setChecked(True)
            self.path.setText(str(path))

        ask_to_open(self, "Choose a calibration", self._folder, FILES, use)

    def _on_changed(self) -> None:
        for field in (self.path, self.browse):
            field.setEnabled(self.from_file.isChecked())
        self._read_file()
        self._list_cameras()
        self._area.setVisible(bool(self._cameras))
        self._check()

    def _read_file(self) -> None:
        """Read what is named; where its reading is open, say what was tried."""
        self._read, self._decided, self._complaint = None, None, ""
        unit, convention = self.unit.currentData() or None, self.convention.currentData() or None
        foreign = bool(unit or convention)
        if self.from_file.isChecked() and self._paths():
            try:
                self._read, self._decided = with_calibration(
                    self._choices, self._paths(), unit=unit, convention=convention
                )
                foreign = foreign or self._decided is not None
            except Undecided as question:
                self._complaint = f"Choose the unit or the convention: {question.what}."
                foreign = True
            except InputError as error:
                self._complaint = str(error)
        self.how.setVisible(foreign and self.from_file.isChecked())

    def _list_cameras(self) -> None:
        """A field for each camera here: which of the file's cameras it is."""
        before = {name: box.currentData() for name, box in self._cameras.items()}
        while self._form.rowCount():
            self._form.removeRow(0)
        self._cameras.clear()
        if self._read is None or self._read.calibration is None:
            return  # it is said below
        known = self._read.given or read_calibration(self._read.calibration)
        for name in self._choices.camera_names():
            options = [("", "choose"), *((one, one) for one in known)]
            box = choice(f"Camera of {name}", options, f"Which camera of the file {name} is")
            with QSignalBlocker(box):
                wanted = before.get(name) or self._read.cameras.get(name, "")
                box.setCurrentIndex(max(box.findData(wanted), 0))
            box.currentIndexChanged.connect(self._check)
            self._form.addRow(name, box)
            self._cameras[name] = box

    def _check(self) -> None:
        problem = self._problem()
        unsaid = [name for name, box in self._cameras.items() if not box.currentData()]
        if unsaid and problem:
            problem = f"Say which camera of the file is {' and which is '.join(unsaid)}."
        how = [] if self._decided is None else [*self._decided.reasons, *self._decided.notes]
        said = " ".join(f"{one[:1].upper()}{one[1:]}." for one in how)
        say_in(self.words, problem or said, error=bool(problem))
        self.completeChanged.emit()


def ask_to_attach(context: Context) -> None:
    """Let the person choose a file; ask on only where it does not tell which camera is which."""
    recording, parent = context.session.document.recording, context.docks.dialog_parent
    if recording is None:
        return

    def attach(cameras: Mapping[str, Camera]) -> None:
        if recording is context.session.document.recording:
            replace_cameras(context.session, cameras, "The calibration is attached")

    def show(path: Path) -> None:
        AttachDialog(recording, path, attach, parent).show_or_attach()

    ask_to_open(parent, "Attach a calibration", recording.folder, FILES, show)


class AttachDialog(FormDialog):
    """Asks what a calibration file leaves open: its cameras, unit and convention."""

    def __init__(
        self,
        recording: Recording,
        path: Path,
        attach: Callable[[Mapping[str, Camera]], None],
        parent: QWidget,
    ) -> None:
        super().__init__("Attach a calibration", "Attach", self._take, parent)
        self._attach, self._choices = attach, _choices_of(recording)
        self.page = CalibrationPage(self._choices, recording.folder)
        self.page.completeChanged.connect(self._on_changed)
        self.lay_out((self.page, 1), size=(640, 480))
        self.open_questions = not self.page.use_file(path)

    def show_or_attach(self) -> None:
        if self.open_questions or not self.page.isComplete():
            self._on_changed()
            self.open()
        else:
            self._take()

    def _on_changed(self) -> None:
        self.accept_button.setEnabled(self.page.isComplete())

    def _take(self) -> None:
        chosen = self.page.chosen(self._choices)
        known = cameras_for(chosen)
        ours = {name: chosen.cameras.get(name, name) for name in chosen.camera_names()}
        cameras = {name: replace(known[theirs], name=name) for name, theirs in ours.items()}
        if self.attempt(lambda: self._attach(cameras)):
            self.accept()


def _choices_of(recording: Recording) -> Choices:
    """The recording as if it were to be made: its cameras, and the sizes of their images."""
    turned = {
        one.camera: view.display_rotation
        for view in recording.views
        for one in view.streams().values()
        if one.camera
    }
    known = [(name, one) for name, one in recording.cameras.items() if name in turned]
    sources = (
        Source(name, recording.folder, "video", one.width, one.height, 0, turned=turned[name])
        for name, one in known
    )
    uses = tuple(Use(source, view=source.name) for source in sources)
    return Choices(recording.name, uses, recording.fps)
