"""Write clicks to a file, after a look at what is there."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PySide6.QtCore import Signal, Slot
from PySide6.QtWidgets import QFileDialog, QWidget

from stereotrack_core.annotation.click import Click
from stereotrack_core.counting import counted
from stereotrack_core.errors import InputError
from stereotrack_core.interop.labels import read_clicks, write_clicks
from stereotrack_core.project.selection import Selection
from stereotrack_core.recording.description import Recording

from ....services.tasks.task import TaskList
from ....widgets.forms.form_dialog import FormDialog, line_edit, push_button
from ....widgets.style.building import choice, hbox, label


class ExportDialog(FormDialog):
    """Which clicks, to which file, and what becomes of that file.

    Parameters
    ----------
    clicks, landmarks : tuple
        All of the project.
    path : Path
        Proposed file.
    tasks : TaskList
        Where the file is written.
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
