"""Which file is imported, and what it does not say itself."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PySide6.QtCore import Signal, Slot
from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QFormLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from stereotrack_core.errors import InputError

from .importing import LabelFile, names_in

_FILES = (
    "Labels and references (*.csv *.json *.npz *.trc *.c3d);;"
    "Clicks and DeepLabCut (*.csv);;COCO keypoints (*.json);;"
    "Trajectories (*.npz *.trc *.c3d *.csv)"
)
_WORDS = (
    "Clicks, DeepLabCut labels and COCO keypoints are compared with the project before anything "
    "is written. A trajectory is added as a reference of the project."
)


class ImportDialog(QDialog):
    """A file, the camera that it is of, and what its landmarks are called here.

    Signals
    -------
    chosen : LabelFile
    """

    chosen = Signal(object)

    def __init__(self, cameras: Sequence[str], folder: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle("Import clicks")
        self._folder = folder
        words = QLabel(_WORDS)
        words.setWordWrap(True)
        words.setProperty("role", "muted")
        self.path = QLineEdit()
        self.path.setAccessibleName("File")
        self.path.textChanged.connect(self._check)
        browse = QPushButton("&Choose …")
        browse.setAutoDefault(False)
        browse.clicked.connect(self._ask)
        row = QHBoxLayout()
        row.addWidget(self.path, 1)
        row.addWidget(browse)
        self.camera = QComboBox()
        self.camera.addItem("as stated in the file", None)
        for name in cameras:
            self.camera.addItem(name, name)
        self.camera.setToolTip("DeepLabCut and COCO files often hold a single camera.")
        self.names = QLineEdit()
        self.names.setPlaceholderText("left_wrist=left_hand, nose=head")
        self.names.setToolTip("Landmark names in the file and their names here, where they differ")
        self.names.textChanged.connect(self._check)
        form = QFormLayout()
        form.addRow("File", row)
        form.addRow("Camera", self.camera)
        form.addRow("Names", self.names)
        self.failure = QLabel()
        self.failure.setWordWrap(True)
        self.failure.setProperty("role", "error")
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Cancel)
        self.compare_button = buttons.addButton("Compare …", QDialogButtonBox.ButtonRole.AcceptRole)
        buttons.accepted.connect(self._accept)
        buttons.rejected.connect(self.reject)
        layout = QVBoxLayout(self)
        layout.addWidget(words)
        layout.addLayout(form)
        layout.addWidget(self.failure)
        layout.addStretch(1)
        layout.addWidget(buttons)
        self.resize(560, 250)
        self._check()

    @Slot()
    def _ask(self) -> None:
        chosen, _ = QFileDialog.getOpenFileName(self, "Import clicks", self._folder, _FILES)
        if chosen:
            self.path.setText(chosen)

    @Slot()
    def _check(self) -> None:
        self.failure.hide()
        self.compare_button.setEnabled(bool(self.path.text().strip()))

    @Slot()
    def _accept(self) -> None:
        path = Path(self.path.text().strip())
        try:
            names = names_in(self.names.text())
            if not path.is_file():
                raise InputError(
                    "there is no such file", where=str(path), remedy="Choose another file."
                )
        except InputError as error:
            self.failure.setText(str(error))
            self.failure.show()
            return
        self.chosen.emit(LabelFile(path, self.camera.currentData(), names))
        self.accept()
