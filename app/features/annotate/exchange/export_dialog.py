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

from stereotrack_core.annotation.click import Click
from stereotrack_core.project.selection import Selection
from stereotrack_core.recording.description import Recording

from ....services.tasks.task import TaskList
from .exporting import export_clicks, export_preview


class ExportDialog(QDialog):
    """Which clicks, to which file, and what becomes of that file.

    Parameters
    ----------
    clicks : tuple of Click
        All of the project.
    landmarks : tuple of str
        Of the project.
    recording : Recording
    selection : Selection or None
    path : Path
        Proposed file.
    tasks : TaskList
        Where the file is written.

    Signals
    -------
    written : str
        What was done, in words.
    """

    written = Signal(str)

    def __init__(
        self,
        clicks: tuple[Click, ...],
        landmarks: tuple[str, ...],
        recording: Recording,
        selection: Selection | None,
        path: Path,
        tasks: TaskList,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle("Export clicks")
        self._clicks, self._landmarks = clicks, landmarks
        self._recording, self._selection, self._tasks = recording, selection, tasks
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
        note = QLabel("Flags, click uncertainties and annotators cannot be stored in this format.")
        note.setProperty("role", "muted")
        self.buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Cancel)
        self.write_button = self.buttons.addButton("Export", QDialogButtonBox.ButtonRole.AcceptRole)
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
        chosen = self._selection
        if self.choice.currentIndex() == 1 and chosen is not None:
            return [
                one
                for one in self._clicks
                if one.frame in chosen.frames and chosen.has(one.landmark)
            ]
        return self._clicks

    def target(self) -> Path:
        """The file that would be written."""
        path = Path(self.path.text().strip())
        return path if path.suffix or not path.name else path.with_suffix(".csv")

    @Slot()
    def _look(self) -> None:
        clicks = self.clicks()
        names = tuple(dict.fromkeys((*self._landmarks, *(click.landmark for click in clicks))))
        found = export_preview(clicks, self.target(), self._recording, names)
        self.preview.setText(found.words if clicks else "There are no clicks to export.")
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
        clicks, path, recording = self.clicks(), self.target(), self._recording
        self.write_button.setEnabled(False)
        task = self._tasks.begin(
            "writing clicks", lambda _task: export_clicks(clicks, path, recording), self._on_written
        )
        task.failed.connect(self._on_failed)

    @Slot(object)
    def _on_written(self, words: str) -> None:
        self.written.emit(words)
        self.accept()

    @Slot(object)
    def _on_failed(self, error: Exception) -> None:
        self.warning.setText(str(error))
        self.warning.show()
        self.write_button.setEnabled(True)
