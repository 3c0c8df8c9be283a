"""Which file is imported, and what it does not say itself."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PySide6.QtCore import Signal, Slot
from PySide6.QtWidgets import QFileDialog, QFormLayout, QWidget

from stereotrack_core.errors import InputError
from stereotrack_core.interop.label_source import LabelSource, stated_names
from stereotrack_core.recording.description import Recording

from ....widgets.forms.form_dialog import FormDialog, line_edit, push_button
from ....widgets.style.building import choice, hbox, label

_FILES = (
    "Labels and references (*.csv *.json *.npz *.trc *.c3d);;"
    "Clicks and DeepLabCut (*.csv);;COCO keypoints (*.json);;"
    "Trajectories (*.npz *.trc *.c3d *.csv)"
)
_WORDS = (
    "Clicks, DeepLabCut labels and COCO keypoints are compared with the project before anything "
    "is written. A trajectory is added as a reference of the project."
)


class ImportDialog(FormDialog):
    """A file, the camera that it is of, and what its landmarks are called here."""

    chosen = Signal(object)

    def __init__(
        self,
        recording: Recording,
        landmarks: Sequence[str],
        folder: str,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__("Import clicks", "Compare …", self._on_accepted, parent)
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
        self.path.textChanged.connect(self._check)
        self.names.textChanged.connect(self._check)
        form = QFormLayout()
        form.addRow("File", hbox((self.path, 1), push_button("&Choose …", self._ask)))
        form.addRow("Camera", self.camera)
        form.addRow("Names", self.names)
        self.lay_out(label(_WORDS, "muted"), form, None, size=(560, 250))
        self._check()

    def _ask(self) -> None:
        chosen, _ = QFileDialog.getOpenFileName(self, "Import clicks", self._folder, _FILES)
        if chosen:
            self.path.setText(chosen)

    @Slot()
    def _check(self) -> None:
        self.say("")
        self.accept_button.setEnabled(bool(self.path.text().strip()))

    def _on_accepted(self) -> None:
        path = Path(self.path.text().strip())

        def take() -> None:
            names = stated_names(self.names.text().split(","))
            if not path.is_file():
                raise InputError(
                    "there is no such file", where=str(path), remedy="Choose another file."
                )
            camera = self.camera.currentData() or None
            source = LabelSource(path, self._recording, self._landmarks, camera, names or None)
            self.chosen.emit(source)

        if self.attempt(take):
            self.accept()
