"""Opening and saving: dialogs about recordings, projects and stored runs, and the demo."""

from functools import partial
from pathlib import Path

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QFileDialog, QMessageBox

from stereotrack_core.demo import DemoPlaces, copied_demo
from stereotrack_core.errors import InputError
from stereotrack_core.interop.run_file import read_run, write_run
from stereotrack_core.locks import user
from stereotrack_core.project.exporting import Exported, ExportFormat, export_run, formats_of
from stereotrack_core.project.whereabouts import SUFFIX
from stereotrack_core.tracking.unfinished import INCOMPLETE

from ...context import Context
from ...services.tasks.task import Task
from ...session.changes import Part
from ...session.edits import Moved
from ...session.opening import Opening
from ...session.runs import RunEntry, entry_of_run
from ...widgets.forms.form_dialog import (
    ask_for_folder,
    ask_for_text,
    ask_to_export,
    ask_to_open,
    ask_to_save,
)
from ...widgets.forms.message import Message


def recent_folder(opening: Opening) -> Path:
    """Folder of what was opened last, where dialogs start."""
    recent = opening.recents()
    return recent[0].parent if recent else Path.home()


class FileController:
    """Everything between the window and the file system."""

    def __init__(self, context: Context) -> None:
        self._context, self._session = context, context.session
        self.demo: DemoPlaces | None = None
        changes = context.session.changes
        changes.watch(Part.READY, self._on_ready)
        changes.hear(Part.RUN_WANTED, self.open_run)
        changes.hear(Part.RUN_ALONE, self._ask_where_recording_is)
        changes.watch(Part.RECENT, self._list_recents)
        self.recents = tuple(self._session.opening.recents())

    def ask_for_recording(self) -> None:
        parent, opening = self._context.docks.dialog_parent, self._session.opening
        ask_for_folder(parent, "Open a recording folder", recent_folder(opening), opening.open)

    def close_recording(self) -> None:
        self._session.track.stop()
        self.demo = None
        self._context.tasks.after_writes(self._session.document.close)

    def begin_demo(self, folder: Path | None = None) -> None:
        """Copy the demo recording unless it is there, open it and track it."""

        def begin() -> None:
            self.demo = places = copied_demo(folder)
            self._session.opening.open(places.recording, workspace="track", tracks=True)

        self._context.notifier.attempt(begin)

    def _on_ready(self) -> None:
        asked = self._session.opening.due()
        if asked.run is not None:
            self.open_run(asked.run)
        if asked.workspace:
            self._context.docks.show_named(asked.workspace)
        if asked.tracks:
            self._session.tracker.run()

    def _list_recents(self) -> None:
        self.recents = tuple(self._session.opening.recents())
        self._context.actions.refresh_soon()

    def open_recent(self, place: int) -> None:
        if place < len(self.recents):
            self._session.opening.open(self.recents[place])

    # ---- runs

    def _ask_where_recording_is(self, path: Path) -> None:
        parent, opening = self._context.docks.dialog_parent, self._session.opening
        title, start = f"Where is the recording of {path.name}?", path.parent
        ask = partial(ask_for_folder, parent, title, start, partial(opening.open, run=path))
        what = "the recording of this run was not found"
        remedy = "Choose its folder to see the run over its images."
        message = Message("warning", what, path.name, remedy, "Choose folder …", ask)
        self._context.notifier.show(message)

    def ask_for_run(self) -> None:
        parent, use = self._context.docks.dialog_parent, self._session.opening.open
        ask_to_open(parent, "Open a run", "", "Run (*.npz *.part)", use)

    def open_run(self, path: Path) -> None:
        try:
            entry = entry_of_run(read_run(path), path)
        except InputError as error:
            self._context.notifier.error(error)
            return
        recording = self._session.document.recording
        assert entry.stored is not None  # noqa: S101 - it was read a moment ago
        made_of = entry.stored.meta.get("recording")
        if recording is not None and made_of not in {None, recording.name}:
            what = f"this run was tracked in the recording {made_of}, not in {recording.name}"
            remedy = "Its curves may be meaningless here."
            self._context.notifier.show(Message("warning", what, path.name, remedy))
        if entry.stored.meta.get(INCOMPLETE):
            what = f"this run was stopped after {len(entry.frames)} frames"
            remedy = (
                "If its .part file still exists, `stereotrack track --resume` continues the run."
            )
            self._context.notifier.show(Message("note", what, path.name, remedy))
        self._session.runs.add(entry)

    def ask_where_to_save(self) -> None:
        active = self._session.runs.active
        if active is None:
            return
        parent, name = self._context.docks.dialog_parent, active.path or Path("run.npz")
        first, *others = sorted(formats_of("run"), key=lambda form: form.name != "npz")
        ask_to_export(parent, "Save run", name, [first, *others], partial(self.export, active))

    def export(self, entry: RunEntry, path: Path, form: ExportFormat) -> None:
        held = entry.now()

        def write(_task: Task) -> Exported:
            run = held.run()
            if run is None:
                raise InputError("the run has no frames", remedy="Track the recording first.")
            return export_run(path, run, form)

        def done(written: Exported) -> None:
            if form.name == "npz":
                entry.path = path
            self._context.notifier.say(written.words(), 8000)

        self._context.tasks.begin(f"saving {path.name}", write, done, promised=True)

    def save_run(self, entry: RunEntry, path: Path) -> None:
        run = entry.run()
        if run is None:
            return
        if self._context.notifier.attempt(lambda: write_run(path, run)):
            entry.path = path
            self._context.notifier.say(f"Run saved to {path}.", 6000)


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


class ProjectController:
    """Dialogs about projects."""

    def __init__(self, context: Context) -> None:
        self._context, self._session = context, context.session
        # the dialog comes when the message about it stands there already
        soon = partial(QTimer.singleShot, 0)
        ask = self._ask_where_recording_is
        context.session.changes.hear(Part.RECORDING_MISSING, lambda path: soon(partial(ask, path)))
        context.session.changes.hear(Part.MOVED, self._show_what_moved)

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
        parent, project = self._context.docks.dialog_parent, self._session.project
        words, name = "Name to store your edits under:", project.annotator or user()
        ask_for_text(parent, "Annotator", words, project.set_annotator, name)

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
        parent = self._context.docks.dialog_parent
        buttons = button.Yes | button.Retry | button.Cancel
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
