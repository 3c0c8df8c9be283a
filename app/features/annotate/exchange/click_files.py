"""Ask for a file of clicks or of a trajectory, and what its names mean here."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from PySide6.QtCore import Slot
from PySide6.QtWidgets import QFormLayout, QWidget

from stereotrack_core.errors import InputError
from stereotrack_core.interop.label_source import LabelSource, stated_names
from stereotrack_core.interop.labels import LABEL_SUFFIXES
from stereotrack_core.interop.landmark_file import world_from_axes
from stereotrack_core.interop.run_file import TRAJECTORY_SUFFIXES
from stereotrack_core.recording.description import Recording

from ....widgets.forms.form_dialog import FormDialog, ask_to_open, files_of, line_edit, push_button
from ....widgets.style.building import choice, hbox, label

_FILES = ";;".join(
    (
        files_of("Labels and references", (*LABEL_SUFFIXES, *TRAJECTORY_SUFFIXES)),
        files_of("Labels", LABEL_SUFFIXES),
        files_of("Trajectories", TRAJECTORY_SUFFIXES),
    )
)
_WORDS = (
    "Clicks, DeepLabCut labels and COCO keypoints are compared with the project before anything "
    "is written. A trajectory is added as a reference of the project."
)
_AS_STATED = "as stated in the file"
_AXES = ("x,y,z", "-x,-y,z", "z,x,y", "x,-z,y", "x,z,-y")


class ImportDialog(FormDialog):
    """A file, the camera that it is of, and what its landmarks are called here."""

    def __init__(
        self,
        recording: Recording,
        landmarks: Sequence[str],
        folder: str,
        use: Callable[[LabelSource], object],
        parent: QWidget | None = None,
    ) -> None:
        super().__init__("Import clicks", "Compare …", self._on_accepted, parent)
        self._use = use
        self._recording, self._landmarks, self._folder = recording, landmarks, folder
        cameras = dict.fromkeys((*(view.name for view in recording.views), *recording.cameras))
        self.path = line_edit("File")
        self.camera = choice(
            "Camera",
            [("", "as stated in the file"), *((name, name) for name in cameras)],
            "DeepLabCut and COCO files often hold a single camera.",
        )
        self.names = line_edit(
            "Names",
            placeholder="left_wrist=left_hand, nose=head",
            tip="Landmark names in the file and their names here, where they differ",
        )
        self.axes = choice(
            "Axes",
            [("", _AS_STATED), *((axes, axes) for axes in _AXES)],
            "Of a trajectory: the file's axes that point east, north and up, such as x,-z,y.",
        )
        self.axes.setEditable(True)
        self.path.textChanged.connect(self._check)
        self.names.textChanged.connect(self._check)
        form = QFormLayout()
        form.addRow("File", hbox((self.path, 1), push_button("&Choose …", self._ask)))
        for field in (self.camera, self.names, self.axes):
            form.addRow(field.accessibleName(), field)
        self.lay_out(label(_WORDS, "muted"), form, None, size=(560, 280))
        self._check()

    def ask_again(self, source: LabelSource, complaint: str) -> None:
        self.path.setText(str(source.path))
        self.names.setText(", ".join(f"{one}={two}" for one, two in (source.names or {}).items()))
        self.axes.setCurrentText(source.axes or _AS_STATED)
        self.axes.setFocus()
        self.say(complaint, error=True)

    def _ask(self) -> None:
        use = self.path.setText
        ask_to_open(self, "Import clicks", self._folder, _FILES, lambda path: use(str(path)))

    @Slot()
    def _check(self) -> None:
        self.say("")
        self.accept_button.setEnabled(bool(self.path.text().strip()))

    def _on_accepted(self) -> None:
        path = Path(self.path.text().strip())

        def take() -> None:
            names = stated_names(self.names.text().split(","))
            if not path.is_file():
                remedy = "Choose another file."
                raise InputError("there is no such file", where=str(path), remedy=remedy)
            camera = self.camera.currentData() or None
            axes = self.axes.currentText().strip().replace(_AS_STATED, "")
            if axes:
                world_from_axes(axes, "Axes")
            known = self._recording, self._landmarks
            self._use(LabelSource(path, *known, camera, names or None, axes))

        if self.attempt(take):
            self.accept()
