"""What is asked about projects: which file, where the recording is, who annotates."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, QTimer, Slot
from PySide6.QtWidgets import QFileDialog, QInputDialog, QMessageBox

from stereotrack_core.errors import InputError
from stereotrack_core.project.history import Changed
from stereotrack_core.project.owner import user
from stereotrack_core.project.rescue import Rescued, rescue
from stereotrack_core.project.whereabouts import SUFFIX

from ...services.failures import Message
from ...services.tasks.task import Task

if TYPE_CHECKING:
    from ...shell.main_window import MainWindow

_FILTER = f"Projects (*{SUFFIX})"


class ProjectWork(QObject):
    """Dialogs about projects."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._w = window
        window.project.recording_missing.connect(self._on_missing)
        window.project.history_moved.connect(self._show_what_moved)

    def ask_for_project(self) -> None:
        """Let the person choose a project file."""
        recent = self._w.files.recent()
        start = str(recent[0].parent) if recent else str(Path.home())
        chosen, _ = QFileDialog.getOpenFileName(self._w, "Open a project", start, _FILTER)
        if chosen:
            self._w.files.open(Path(chosen))

    def ask_for_copy(self) -> None:
        """Let the person choose where a copy of the project goes, and write it."""
        project = self._w.project.project
        if project is None:
            return
        proposed = project.path.with_stem(f"{project.path.stem}-copy")
        chosen, _ = QFileDialog.getSaveFileName(
            self._w, "Save a copy of the project", str(proposed), _FILTER
        )
        if not chosen:
            return
        try:
            project.save_copy(_with_suffix(chosen))
        except InputError as error:
            self._w.show_error(error)
            return
        self._w.statusBar().showMessage(f"The copy is {_with_suffix(chosen)}.", 6000)

    def take_over(self) -> None:
        """Open for writing what another program is said to have, if the person is sure."""
        path = self._w.project.path
        if path is None:
            return
        sure = QMessageBox.question(
            self._w,
            "Take the project over",
            "If the other program still works on this project, edits can get lost. Is it gone "
            "for certain?",
        )
        if sure == QMessageBox.StandardButton.Yes:
            self._w.project.open_file(path, self._w.document.frame, take_over=True)

    def ask_what_to_rescue(self) -> None:
        """Let the person choose a damaged project and where to save what can be read."""
        damaged, _ = QFileDialog.getOpenFileName(self._w, "Rescue a project", "", _FILTER)
        if not damaged:
            return
        proposed = Path(damaged).with_stem(f"{Path(damaged).stem}-rescued")
        target, _ = QFileDialog.getSaveFileName(
            self._w, "Save what can be read", str(proposed), _FILTER
        )
        if not target:
            return

        def work(_task: Task) -> Rescued:
            return rescue(Path(damaged), _with_suffix(target))

        self._w.tasks.begin("rescuing the project", work, self._on_rescued)

    @Slot(object)
    def _on_rescued(self, rescued: Rescued) -> None:
        rows = sum(rescued.rows.values())
        history = "with its history" if rescued.history_whole else "its history was damaged"
        self._w.messages.show_message(
            Message("note", f"{rows} rows were rescued, {history}", str(rescued.path))
        )
        self._w.files.open(rescued.path)

    def ask_for_home(self) -> None:
        """Let the person choose where new projects go."""
        home = self._w.project.wishes().home
        chosen = QFileDialog.getExistingDirectory(
            self._w, "Folder of new projects", str(home or Path.home())
        )
        if chosen:
            self._w.project.set_home(Path(chosen))

    def keep_beside(self) -> None:
        """Let new projects lie beside their recordings."""
        self._w.project.set_home(None)

    def kept_beside(self) -> bool:
        """Whether new projects lie beside their recordings."""
        return self._w.project.wishes().home is None

    def ask_annotator(self) -> None:
        """Let the person say whose name edits get."""
        dialog = QInputDialog(self._w)
        dialog.setWindowTitle("Who annotates")
        dialog.setLabelText("Name that edits are signed with:")
        dialog.setTextValue(self._w.project.annotator or user())
        dialog.textValueSelected.connect(self._w.project.set_annotator)
        dialog.open()

    @Slot(object)
    def _on_missing(self, path: Path) -> None:
        # the dialog comes when the message about it stands there already
        QTimer.singleShot(0, lambda: self._ask_where_recording_is(path))

    def _ask_where_recording_is(self, path: Path) -> None:
        title = f"Where is the recording of {path.name}?"
        chosen = QFileDialog.getExistingDirectory(self._w, title, str(path.parent))
        if not chosen:
            self._w.project.give_up()
            return
        try:
            self._w.project.use_recording(Path(chosen))
        except InputError as error:
            self._ask_about_another(path, Path(chosen), error)
        else:
            self._w.messages.clear()

    def _ask_about_another(self, path: Path, folder: Path, error: InputError) -> None:
        """Where the folder holds another recording: take it all the same, or look elsewhere."""
        button = QMessageBox.StandardButton
        answer = QMessageBox.question(
            self._w,
            "Another recording",
            f"{folder.name}: {error.what}.\n\nUse this folder all the same? Clicks that do not "
            "belong to its pictures stay as they are.",
            button.Yes | button.Retry | button.Cancel,
        )
        if answer == button.Retry:
            self._ask_where_recording_is(path)
            return
        if answer != button.Yes:
            self._w.project.give_up()
            return
        try:
            self._w.project.use_recording(folder, even_another=True)
        except InputError as still:
            self._w.project.give_up()
            self._w.show_error(still)

    @Slot(object)
    def _show_what_moved(self, changed: Changed) -> None:
        """Go to the frame of what was taken back or made again, and say what it was."""
        frames = changed.frames() | changed.frames("frame_flag") | changed.frames("keyframe")
        document = self._w.document
        if frames and document.frame not in frames:
            document.pause()
            document.go_to(min(frames))
        self._w.statusBar().showMessage(f"{changed.how.capitalize()}: {changed.words}.", 5000)


def _with_suffix(chosen: str) -> Path:
    path = Path(chosen)
    return path if path.suffix == SUFFIX else path.with_name(f"{path.name}{SUFFIX}")
