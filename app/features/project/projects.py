"""What is asked about projects: which file, where the recording is, who annotates."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QObject, Qt, QTimer, Slot
from PySide6.QtWidgets import QFileDialog, QInputDialog, QMessageBox

from stereotrack_core.errors import InputError
from stereotrack_core.locks import user
from stereotrack_core.project.whereabouts import SUFFIX

from ...context import Context
from ...session.edits import Moved
from ...widgets.forms.form_dialog import ask_for_folder, ask_to_open, ask_to_save
from .files import recent_folder

_FILTER = f"Projects (*{SUFFIX})"
_WITH_FRAMES = ("click", "repeat_click", "frame_flag", "keyframe")
"""Tables of the project whose rows belong to frames."""
_SEEN_IN = {
    **dict.fromkeys((*_WITH_FRAMES, "landmark_set"), ("annotate", "landmarks")),
    **dict.fromkeys(("reference", "subject"), ("annotate", "body")),
    "parameter_set": ("tune", "parameters"),
    "run": ("track", "runs"),
    "description": ("calibrate", "findings"),
}
"""Workspace and panel that show what a table of the project holds."""


class ProjectController(QObject):
    """Dialogs about projects."""

    def __init__(self, context: Context) -> None:
        super().__init__(context.session)
        self._context, self._session = context, context.session
        context.session.project.recording_missing.connect(self._on_missing)
        context.session.edits.moved.connect(self._show_what_moved)

    def ask_for_project(self) -> None:
        parent, opening = self._context.docks.dialog_parent, self._session.opening
        ask_to_open(parent, "Open project", recent_folder(opening), _FILTER, opening.open)

    def ask_for_copy(self) -> None:
        project = self._session.project.project
        if project is None:
            return
        proposed = project.path.with_stem(f"{project.path.stem}-copy")
        parent, notifier = self._context.docks.dialog_parent, self._context.notifier

        def save(chosen: Path) -> None:
            path = _with_suffix(chosen)
            if notifier.attempt(lambda: project.save_copy(path)):
                notifier.say(f"Copy saved to {path}.", 6000)

        ask_to_save(parent, "Save a copy of the project", proposed, _FILTER, save)

    def take_over(self) -> None:
        path = self._session.project.path
        if path is None:
            return
        sure = QMessageBox.question(
            self._context.docks.dialog_parent,
            "Force unlock project",
            "If the other program is still using this project, edits can be lost. Are you certain "
            "that it is no longer running?",
        )
        if sure == QMessageBox.StandardButton.Yes:
            self._session.project.open_file(path, self._session.document.frame, take_over=True)

    def ask_for_home(self) -> None:
        home = self._session.project.wishes().home or Path.home()
        parent, keep = self._context.docks.dialog_parent, self._session.project.set_home
        ask_for_folder(parent, "Folder for new projects", home, keep)

    def keep_beside(self) -> None:
        self._session.project.set_home(None)

    def kept_beside(self) -> bool:
        return self._session.project.wishes().home is None

    def ask_annotator(self) -> None:
        dialog = QInputDialog(self._context.docks.dialog_parent)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.setWindowTitle("Annotator")
        dialog.setLabelText("Name to store your edits under:")
        dialog.setTextValue(self._session.project.annotator or user())
        dialog.textValueSelected.connect(self._session.project.set_annotator)
        dialog.open()

    @Slot(object)
    def _on_missing(self, path: Path) -> None:
        # the dialog comes when the message about it stands there already
        QTimer.singleShot(0, lambda: self._ask_where_recording_is(path))

    def _ask_where_recording_is(self, path: Path) -> None:
        title = f"Where is the recording of {path.name}?"
        chosen = QFileDialog.getExistingDirectory(
            self._context.docks.dialog_parent, title, str(path.parent)
        )
        if not chosen:
            self._session.project.give_up()
            return
        try:
            self._session.project.use_recording(Path(chosen))
        except InputError as error:
            self._ask_about_another(path, Path(chosen), error)
        else:
            self._context.notifier.clear()

    def _ask_about_another(self, path: Path, folder: Path, error: InputError) -> None:
        """Where the folder holds another recording: take it all the same, or look elsewhere."""
        button = QMessageBox.StandardButton
        question = (
            f"{folder.name}: {error.what}.\n\nUse this folder anyway? Clicks that do not fit its "
            "images are kept as they are."
        )
        parent, buttons = (
            self._context.docks.dialog_parent,
            button.Yes | button.Retry | button.Cancel,
        )
        answer = QMessageBox.question(parent, "Different recording", question, buttons)
        if answer == button.Retry:
            self._ask_where_recording_is(path)
            return
        if answer != button.Yes:
            self._session.project.give_up()
            return
        try:
            self._session.project.use_recording(folder, even_another=True)
        except InputError as still:
            self._session.project.give_up()
            self._context.notifier.error(still)

    @Slot(object)
    def _show_what_moved(self, moved: Moved) -> None:
        """Go to where what was undone or redone can be seen, and say what it was."""
        edit, changed = moved.edit, moved.changed
        frames = frozenset[int]()
        workspace, panel = ("", "") if edit is None else (edit.workspace, edit.panel)
        if changed is not None:
            frames = frozenset(k for name in _WITH_FRAMES for k in changed.frames(name))
            places = (_SEEN_IN[name] for name in sorted(changed.tables) if name in _SEEN_IN)
            workspace, panel = next(places, ("", ""))
        document, docks = self._session.document, self._context.docks
        if panel:
            docks.show_workspace_for(panel, workspace)
        if panel and not frames:
            docks.bring_up(panel)
        if frames and document.frame not in frames:
            document.visit(min(frames))
        self._context.notifier.say(f"{moved.how.capitalize()}: {moved.words}.", 5000)


def _with_suffix(path: Path) -> Path:
    return path if path.suffix == SUFFIX else path.with_name(f"{path.name}{SUFFIX}")
