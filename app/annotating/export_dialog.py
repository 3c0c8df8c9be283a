"""Write clicks to a file, after a look at what is there."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PySide6.QtCore import Signal, Slot
from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from app.presenters.exporting import export_clicks, export_preview
from app.presenters.selection import Selection, selected_clicks
from stereotrack_core.annotation.click import Click
from stereotrack_core.errors import InputError
from stereotrack_core.project.project import Project
from stereotrack_core.recording.description import Recording


class ExportDialog(QDialog):
    """Which clicks, to which file, and what becomes of that file.

    Signals
    -------
    written : str
        What was done, in words.
    """

    written = Signal(str)

    def __init__(
        self,
        project: Project,
        recording: Recording,
        selection: Selection | None,
        path: Path,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle("Export clicks")
        self._project, self._recording, self._selection = project, recording, selection
        self.choice = QComboBox()
        self.choice.setAccessibleName("Which clicks")
        self.choice.addItem("All clicks of the project")
        if selection is not None:
            self.choice.addItem(f"Only {selection.words()}")
            self.choice.setCurrentIndex(1)
        self.path = QLineEdit(str(path))
        self.path.setAccessibleName("File")
        browse = QPushButton("&Choose …")
        browse.setAutoDefault(False)
        browse.clicked.connect(self._ask)
        row = QHBoxLayout()
        row.addWidget(self.path, 1)
        row.addWidget(browse)
        self.preview = QLabel()
        self.preview.setWordWrap(True)
        self.warning = QLabel()
        self.warning.setWordWrap(True)
        self.warning.setProperty("role", "error")
        note = QLabel("Flags, sigmas and authors have no column in this format.")
        note.setProperty("role", "muted")
        self.buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Cancel)
        self.write_button = self.buttons.addButton("Write", QDialogButtonBox.ButtonRole.AcceptRole)
        self.buttons.accepted.connect(self._write)
        self.buttons.rejected.connect(self.reject)
        layout = QVBoxLayout(self)
        layout.addWidget(self.choice)
        layout.addLayout(row)
        for widget in (self.preview, self.warning, note):
            layout.addWidget(widget)
        layout.addStretch(1)
        layout.addWidget(self.buttons)
        self.resize(560, 260)
        self.path.editingFinished.connect(self._look)
        self.choice.currentIndexChanged.connect(self._look)
        self._look()

    def clicks(self) -> Sequence[Click]:
        """The clicks that would be written."""
        if self.choice.currentIndex() == 1 and self._selection is not None:
            return selected_clicks(self._project, self._selection)
        return self._project.clicks.all()

    def target(self) -> Path:
        """The file that would be written."""
        path = Path(self.path.text().strip())
        return path if path.suffix or not path.name else path.with_suffix(".csv")

    @Slot()
    def _look(self) -> None:
        clicks = self.clicks()
        known = self._project.landmark_set().names
        names = tuple(dict.fromkeys((*known, *(click.landmark for click in clicks))))
        found = export_preview(clicks, self.target(), self._recording, names)
        self.preview.setText(found.words if clicks else "There are no clicks to write.")
        self.warning.setText(found.warning)
        self.warning.setVisible(bool(found.warning))
        self.write_button.setEnabled(bool(clicks) and bool(self.path.text().strip()))

    @Slot()
    def _ask(self) -> None:
        chosen, _ = QFileDialog.getSaveFileName(
            self,
            "Export clicks",
            self.path.text(),
            "Clicks (*.csv)",
            options=QFileDialog.Option.DontConfirmOverwrite,
        )
        if chosen:
            self.path.setText(chosen)
            self._look()

    @Slot()
    def _write(self) -> None:
        try:
            words = export_clicks(self.clicks(), self.target(), self._recording)
        except InputError as error:
            self.warning.setText(str(error))
            self.warning.show()
            return
        self.written.emit(words)
        self.accept()
