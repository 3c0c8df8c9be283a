"""Clicks from files and to files: which file, what it does not say itself, what becomes of it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PySide6.QtCore import Signal, Slot
from PySide6.QtWidgets import QFileDialog, QFormLayout, QWidget

from stereotrack_core.annotation.click import Click
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.interop.label_source import LabelSource, stated_names
from stereotrack_core.interop.labels import read_clicks, write_clicks
from stereotrack_core.project.selection import Selection
from stereotrack_core.recording.description import Recording

from ....services.tasks.task import TaskList
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


class ExportDialog(FormDialog):
    """Which clicks, to which file, and what becomes of that file.

    Parameters
    ----------
    clicks, landmarks : tuple
        All of the project.
    """

    written = Signal(str)
    """What was done, in words."""

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
        super().__init__("Export clicks", "Export", self._write, parent)
        self._clicks, self._landmarks = clicks, landmarks
        self._recording, self._selection, self._tasks = recording, selection, tasks
        self.choice = choice("Which clicks", [("", "All clicks of the project")])
        if selection is not None:
            self.choice.addItem(f"Only {selection.words()}")
            self.choice.setCurrentIndex(1)
        self.path = line_edit("File", str(path))
        self.preview = label()
        note = "Flags, click uncertainties and annotators cannot be stored in this format."
        row = hbox((self.path, 1), push_button("&Choose …", self._ask))
        self.lay_out(self.choice, row, self.preview, label(note, "muted"), None, size=(560, 260))
        self.path.editingFinished.connect(self._look)
        self.choice.currentIndexChanged.connect(self._look)
        self._look()

    def clicks(self) -> Sequence[Click]:
        """The clicks that would be written."""
        chosen = self._selection
        if self.choice.currentIndex() != 1 or chosen is None:
            return self._clicks
        return [c for c in self._clicks if c.frame in chosen.frames and chosen.has(c.landmark)]

    def target(self) -> Path:
        """The file that would be written."""
        path = Path(self.path.text().strip())
        return path if path.suffix or not path.name else path.with_suffix(".csv")

    @Slot()
    def _look(self) -> None:
        clicks = self.clicks()
        names = tuple(dict.fromkeys((*self._landmarks, *(click.landmark for click in clicks))))
        words, warning = _preview(clicks, self.target(), self._recording, names)
        self.preview.setText(words if clicks else "There are no clicks to export.")
        self.say(warning, error=True)
        self.accept_button.setEnabled(bool(clicks) and bool(self.path.text().strip()))

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

    def _write(self) -> None:
        clicks, path, recording = self.clicks(), self.target(), self._recording
        self.accept_button.setEnabled(False)
        task = self._tasks.begin(
            "writing clicks", lambda _task: _write(clicks, path, recording), self._on_written
        )
        task.failed.connect(self._on_failed)

    @Slot(object)
    def _on_written(self, words: str) -> None:
        self.written.emit(words)
        self.accept()

    @Slot(object)
    def _on_failed(self, error: Exception) -> None:
        self.say(str(error), error=True)
        self.accept_button.setEnabled(True)


def _preview(
    clicks: Sequence[Click], path: Path, recording: Recording, landmarks: Sequence[str]
) -> tuple[str, str]:
    """What writing would do, and what would be lost of the file that would be replaced."""
    frames = len({click.frame for click in clicks})
    words = f"{counted(len(clicks), 'click')} in {counted(frames, 'frame')} will be written."
    if not path.exists():
        return words, ""
    try:
        there = read_clicks(path, recording, landmarks=landmarks)
    except InputError as error:
        return words, f"The existing file will be replaced. It holds no clicks: {error.what}."
    old = {click.key: (click.position, click.visibility) for click in there.clicks}
    new = {click.key: (click.position, click.visibility) for click in clicks}
    both = old.keys() & new.keys()
    same = sum(old[key] == new[key] for key in both)
    lost = len(old) - len(both) + len(there.problems)
    words += (
        f" Of the {counted(len(old), 'click')} in the existing file, {same} stay the same and "
        f"{len(both) - same} change; {len(new) - len(both)} are new."
    )
    return words, f"{counted(lost, 'line')} of the existing file will be lost." if lost else ""


def _write(clicks: Sequence[Click], path: Path, recording: Recording) -> str:
    """Write clicks and read them back; what was done, in words."""
    write_clicks(path, clicks, recording)
    names = tuple(dict.fromkeys(click.landmark for click in clicks))
    again = read_clicks(path, recording, landmarks=names).checked()
    if len(again) != len(clicks):
        raise InputError(
            f"{len(again)} of {len(clicks)} clicks could be read back from the file",
            where=str(path),
            remedy="Export to a different drive.",
        )
    return f"{counted(len(clicks), 'click')} saved to {path}."
