"""Which file is imported, and what it does not say itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from PySide6.QtCore import Signal, Slot
from PySide6.QtWidgets import QFileDialog, QFormLayout, QWidget

from stereotrack_core.annotation.click import Click
from stereotrack_core.errors import InputError
from stereotrack_core.interop.label_source import stated_names
from stereotrack_core.interop.labels import read_labels
from stereotrack_core.project.project import Project
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


@dataclass(frozen=True)
class LabelFile:
    """A file of another tool, and what it does not say itself.

    Attributes
    ----------
    camera : str or None
        Camera or view that its labels are of; None: as the file says.
    names : mapping
        From their landmarks to ours, where the names do not tell.
    """

    path: Path
    camera: str | None = None
    names: Mapping[str, str] = field(default_factory=dict)

    def clicks(
        self, project: Project, recording: Recording, frames: int | None
    ) -> tuple[tuple[Click, ...], tuple[InputError, ...]]:
        """The clicks, and everything that is left out; InputError where it cannot be read."""
        found = read_labels(
            self.path,
            recording,
            landmarks=project.landmark_set().names,
            frames=frames,
            camera=self.camera,
            names=self.names or None,
        )
        left_out = tuple(
            InputError(
                f"all labels of {name!r}: no landmark of this project corresponds to it",
                where=self.path.name,
                remedy=f"To import them, give {name}=... under the names.",
            )
            for name in found.left_out
        )
        return found.clicks, (*left_out, *found.problems)


class ImportDialog(FormDialog):
    """A file, the camera that it is of, and what its landmarks are called here.

    Signals
    -------
    chosen : LabelFile
    """

    chosen = Signal(object)

    def __init__(self, cameras: Sequence[str], folder: str, parent: QWidget | None = None) -> None:
        super().__init__("Import clicks", "Compare …", self._on_accepted, parent)
        self._folder = folder
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
            self.chosen.emit(LabelFile(path, self.camera.currentData() or None, names))

        if self.attempt(take):
            self.accept()
