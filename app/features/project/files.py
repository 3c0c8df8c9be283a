"""Opening and saving: recordings, projects and stored runs, their dialogs, and the demo; undo."""

from dataclasses import replace
from functools import partial
from pathlib import Path

from PySide6.QtCore import QUrl
from PySide6.QtGui import QDesktopServices
from PySide6.QtWidgets import QFileDialog, QMessageBox

from stereotrack_core.demo import DemoPlaces, copied_demo
from stereotrack_core.errors import InputError
from stereotrack_core.interop.run_file import read_run, write_run
from stereotrack_core.locks import user
from stereotrack_core.project.exporting import Exported, ExportFormat, formats_of, writer
from stereotrack_core.project.history import Entry
from stereotrack_core.project.whereabouts import SUFFIX
from stereotrack_core.tracking.unfinished import INCOMPLETE

from ...context import Context
from ...services.actions import Command, Menu
from ...session.changes import Part
from ...session.edits import Moved, WindowEdit
from ...session.jobs import Job, NewestJob, Task
from ...session.messages import Message
from ...session.runs import RunEntry, entry_of_run
from ...session.session import MOST_RECENT, Session
from ...widgets.forms.form_dialog import (
    ask_for_folder,
    ask_for_text,
    ask_to_export,
    ask_to_open,
    ask_to_save,
)
from .importing import ImportController


class FileController:
    """Everything between the window and the file system."""

    def __init__(self, context: Context) -> None:
        self._context, self._session = context, context.session
        self.demo: DemoPlaces | None = None
        self.reports = ReportController(context)
        changes = context.session.changes
        changes.watch(Part.READY, self._on_ready)
        changes.hear(Part.RUN_WANTED, self.open_run)
        changes.hear(Part.RUN_ALONE, self._ask_where_recording_is)
        changes.watch(Part.RECENT, self._list_recents)
        self.recents = tuple(self._session.recents())

    def close_recording(self) -> None:
        def close() -> None:
            self._session.track.stop()
            self.demo = None
            self._context.tasks.after_writes(self._session.document.close)

        self._session.leave("Close", close)

    def begin_demo(self, folder: Path | None = None) -> None:
        """Copy the demo recording unless it is there, open it and track it."""

        def begin() -> None:
            self.demo = places = copied_demo(folder)
            self._session.open(places.recording, workspace="track", tracks=True)

        self._context.notifier.attempt(begin)

    def _on_ready(self) -> None:
        asked = self._session.due()
        if asked.run is not None:
            self.open_run(asked.run)
        if asked.workspace:
            self._context.docks.show_named(asked.workspace)
        if asked.tracks:
            self._session.track.run()

    def _list_recents(self) -> None:
        self.recents = tuple(self._session.recents())
        self._context.actions.refresh_soon()

    def open_recent(self, place: int) -> None:
        if place < len(self.recents):
            self._session.open(self.recents[place])

    def _ask_where_recording_is(self, path: Path) -> None:
        parent, session = self._context.docks.dialog_parent, self._session
        title, start = f"Where is the recording of {path.name}?", path.parent
        ask = partial(ask_for_folder, parent, title, start, partial(session.open, run=path))
        what = "the recording of this run was not found"
        remedy = "Choose its folder to see the run over its images."
        message = Message("warning", what, path.name, remedy, "Choose folder …", ask)
        self._context.notifier.show(message)

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
        active, recording = self._session.runs.active, self._session.document.recording
        if active is None or recording is None:
            return
        parent = self._context.docks.dialog_parent
        name = active.path or Path(f"{recording.folder.name}-run.npz")
        first, *others = sorted(formats_of("run"), key=lambda form: form.name != "npz")
        ask_to_export(parent, "Save run", name, [first, *others], partial(self.export, active))

    def export(self, entry: RunEntry, path: Path, form: ExportFormat) -> None:
        held = entry.now()

        def write(_task: Task) -> Exported:
            run = held.run()
            if run is None:
                raise InputError("the run has no frames", remedy="Track the recording first.")
            return writer(form, "run")(path, run, None)

        def done(written: Exported) -> None:
            if form.name == "npz":
                entry.path = path
            self._context.notifier.exported(written)

        self._context.tasks.run(Job(f"saving {path.name}", write, done), promised=True)

    def save_run(self, entry: RunEntry, path: Path) -> None:
        run = entry.run()
        if run is None:
            return
        if self._context.notifier.attempt(lambda: write_run(path, run)):
            entry.path = path
            self._context.notifier.say(f"Run saved to {path}.", 6000)


_PAGES = "Page for a browser (*.html)"


class ReportController:
    """Writes reports."""

    def __init__(self, context: Context) -> None:
        self._context, self._session = context, context.session
        self.job = NewestJob(context.tasks)

    def why_not(self) -> str:
        busy = "A report is already being written." if self.job.busy else ""
        return self._session.no_run() or busy

    def ask_where(self) -> None:
        entry = self._session.runs.active
        if entry is None:
            return
        beside = entry.path.parent if entry.path is not None else Path.home()
        kept = "".join(one if one.isalnum() or one in "-_." else "-" for one in entry.name)
        proposed = beside / f"report-{kept.strip('-.') or 'run'}.html"

        def make(path: Path) -> None:
            known = path.suffix.lower() in {".html", ".htm"}
            self.make(path if known else path.with_name(f"{path.name}.html"))

        ask_to_save(self._context.docks.dialog_parent, "Save report", proposed, _PAGES, make)

    def make(self, path: Path) -> None:
        from stereotrack_core.report import pages, reported

        entry, recording = self._session.runs.active, self._session.document.recording
        run, truth = None if entry is None else entry.run(), self._session.judging.truth
        if entry is None or recording is None or run is None or self.job.busy:
            return
        file = entry.path
        source = reported.Source(
            name=entry.name, run=run,
            recording=replace(recording, segments=self._session.segments()),
            reference=None if truth is None else truth.trajectory,
            reference_name="" if truth is None else truth.words,
            states=None if truth is None else truth.reference,
            repeat="" if file is None else pages.repeat_command(recording.folder.name, str(file)),
        )  # fmt: skip

        def work(task: Task) -> None:
            pages.write_page(path, reported.gathered(source, task.work))

        def show() -> None:
            QDesktopServices.openUrl(QUrl.fromLocalFile(str(path)))

        def done(_: None) -> None:
            message = Message("note", f"Report saved to {path}", button="Open", do=show)
            self._context.notifier.show(message)

        self.job.run(Job("Writing report", work, done), promised=True)


_FILTER = f"Projects (*{SUFFIX})"
_WITH_FRAMES = ("click", "repeat_click", "frame_flag", "keyframe")
"""Tables of the project whose rows belong to frames."""
_SEEN_IN = {
    **dict.fromkeys((*_WITH_FRAMES, "landmark_set"), ("annotate", "landmarks")),
    **dict.fromkeys(("reference", "subject", "camera_use"), ("annotate", "body")),
    "parameter_set": ("tune", "parameters"),
    "run": ("track", "runs"),
    "description": ("calibrate", "findings"),
}


def _ask_for_copy(context: Context) -> None:
    project, notifier = context.session.project.project, context.notifier
    if project is None:
        return
    proposed = project.path.with_stem(f"{project.path.stem}-copy")

    def save(chosen: Path) -> None:
        path = chosen if chosen.suffix == SUFFIX else chosen.with_name(f"{chosen.name}{SUFFIX}")
        if notifier.attempt(lambda: project.save_copy(path)):
            notifier.say(f"Copy saved to {path}.", 6000)

    parent = context.docks.dialog_parent
    ask_to_save(parent, "Save a copy of the project", proposed, _FILTER, save)


def _take_over(context: Context) -> None:
    project, parent = context.session.project, context.docks.dialog_parent
    question = (
        "If the other program is still using this project, edits can be lost. Are you certain "
        "that it is no longer running?"
    )
    yes, ask = QMessageBox.StandardButton.Yes, QMessageBox.question
    if project.path is not None and ask(parent, "Force unlock project", question) == yes:
        project.open_file(project.path, context.session.document.frame, take_over=True)


def _ask_where_recording_is(context: Context, path: Path) -> None:
    """Ask for the recording of a project that is open otherwise."""
    title, parent = f"Where is the recording of {path.name}?", context.docks.dialog_parent
    chosen = QFileDialog.getExistingDirectory(parent, title, str(path.parent))
    if not chosen:
        context.session.project.give_up()
        return
    try:
        context.session.project.use_recording(Path(chosen))
    except InputError as error:
        _ask_about_another(context, path, Path(chosen), error)
    else:
        context.notifier.clear()


def _ask_about_another(context: Context, path: Path, folder: Path, error: InputError) -> None:
    """Where the folder holds another recording: take it all the same, or look elsewhere."""
    button, project = QMessageBox.StandardButton, context.session.project
    question = (
        f"{folder.name}: {error.what}.\n\nUse this folder anyway? Clicks that do not fit its "
        "images are kept as they are."
    )
    parent, buttons = context.docks.dialog_parent, button.Yes | button.Retry | button.Cancel
    answer = QMessageBox.question(parent, "Different recording", question, buttons)
    if answer == button.Retry:
        _ask_where_recording_is(context, path)
        return
    use = partial(project.use_recording, folder, even_another=True)
    if answer != button.Yes or not context.notifier.attempt(use):
        project.give_up()


def _show_what_moved(context: Context, moved: Moved) -> None:
    """Go to where what was undone or redone can be seen, and say what it was."""
    edit, changed = moved.edit, moved.changed
    frames = frozenset[int]()
    workspace, panel = ("", "") if edit is None else (edit.workspace, edit.panel)
    if changed is not None:
        frames = frozenset(k for name in _WITH_FRAMES for k in changed.frames(name))
        places = (_SEEN_IN[name] for name in sorted(changed.tables) if name in _SEEN_IN)
        workspace, panel = next(places, ("", ""))
    document, docks = context.session.document, context.docks
    if panel:
        docks.show_workspace_for(panel, workspace)
    if panel and not frames:
        docks.bring_up(panel)
    if frames and document.frame not in frames:
        document.visit(min(frames))
    context.notifier.say(f"{moved.how.capitalize()}: {moved.words}.", 5000)


def _files(context: Context, files: FileController, importing: ImportController) -> list[Command]:
    session, own, reports = context.session, context.session.project, files.reports
    command, project = Menu("&File").command, Menu("&File/Project").command
    parent, start = context.docks.dialog_parent, session.recent_folder
    return [
        command("open", "Open a recording …", "Open a recording folder.",
                lambda: ask_for_folder(parent, "Open a recording folder", start(), session.open),
                "Ctrl+O", "open"),
        *_recents(session, files),
        command("open_project", "Open a project …", "Open a project file (.stereotrack) and its "
                "recording.",
                lambda: ask_to_open(parent, "Open project", start(), _FILTER, session.open),
                "Ctrl+Alt+O", "open"),
        command("import_recording", "Make a recording of videos …", "Make a recording folder of "
                "videos, stereo videos, or folders of images or depth maps.",
                importing.ask_for_videos, "", "camera"),
        Menu("&File/&Calibration", session.no_recording).command(
            "attach_calibration", "Attach a calibration …", "Replace the cameras of the open "
            "recording by those of a calibration file; the one before is kept beside it.",
            importing.ask_to_attach),
        command("demo", "Open and track demo", "Open four stereo views of a simulated person "
                "with known ground truth, and track them.", files.begin_demo, icon="run-tracker"),
        command("close", "Close the recording", "Close the recording and show the welcome page. "
                "Changes of parameters can no longer be undone.",
                files.close_recording, "Ctrl+W", why_not=session.no_recording),
        project("copy_project", "Save a copy …", "Write the project in its present state to "
                "another file. The project itself is always saved.",
                partial(_ask_for_copy, context), icon="save", why_not=session.no_project),
        project("take_over", "Force unlock …", "Open for writing a project that is locked by "
                "another program, when that program is certainly no longer running.",
                partial(_take_over, context), icon="lock", why_not=lambda: (
                    "" if own.in_use else "The project is not locked.")),
        project("projects_beside", "Keep new projects beside recordings", "Create the project of "
                "a new recording beside the recording's folder.", partial(own.set_home, None),
                checked=lambda: own.home is None, section=True),
        project("projects_folder", "Keep new projects in folder …", "Choose a folder for the "
                "projects of new recordings.",
                lambda: ask_for_folder(parent, "Folder for new projects",
                                       own.home or Path.home(), own.set_home),
                icon="settings", checked=lambda: own.home is not None),
        command("open_run", "Open run …", "Show a saved run (.npz) with its recording.",
                lambda: ask_to_open(parent, "Open a run", "", "Run (*.npz *.part)", session.open),
                "Ctrl+Shift+O", "open", section=True),
        command("save_run", "Save run as …", "Save the active run complete, or export it to "
                "OpenSim, C3D, BVH or as joint angles.",
                files.ask_where_to_save, "Ctrl+S", "save",
                why_not=session.no_run),
        command("report", "Report …", "Write a report on the active run as a web page: errors, "
                "curves, failures with images, parameters, and how to reproduce it.",
                reports.ask_where, "Ctrl+Shift+R", "export", why_not=reports.why_not),
    ]  # fmt: skip


def _recents(session: Session, files: FileController) -> list[Command]:
    none = "Nothing was opened yet."

    def says(place: int) -> str:
        found = files.recents[place : place + 1]  # none beyond the end of the list
        return "".join(f"{path.name}   {path.parent}" for path in found)

    def there(place: int) -> bool:
        return place < len(files.recents)

    command = Menu("&File/Open &recent", lambda: "" if files.recents else none).command
    return [
        *(command(f"recent_{place + 1}", f"Recent {place + 1}", "Open this recording or project "
                  "again.", partial(files.open_recent, place), says=partial(says, place),
                  shown=partial(there, place)) for place in range(MOST_RECENT)),
        command("forget_recent", "Clear this list", "Forget what was opened. No file is deleted.",
                session.forget_recents, icon="delete", section=True),
    ]  # fmt: skip


def _edits(context: Context) -> list[Command]:
    session = context.session

    def said(verb: str, entry: Entry | WindowEdit | None) -> str:
        return verb if entry is None else f"{verb} {entry.words[:1].upper()}{entry.words[1:]}"

    def nothing(entry: Entry | WindowEdit | None, verb: str) -> str:
        none = session.no_edit() or f"There is nothing to {verb}."
        return none if entry is None else ""

    edits, command = session.edits, Menu("&Edit").command
    return [
        command("undo", "Undo", "Undo what was done last, and show where: clicks and other edits "
                "of the project without limit, parameters as long as the recording is open.",
                edits.undo, "Ctrl+Z", "undo",
                why_not=lambda: nothing(edits.to_undo(), "undo"),
                says=lambda: said("Undo", edits.to_undo())),
        command("redo", "Redo", "Redo what was undone last.", edits.redo, "Ctrl+Shift+Z", "redo",
                why_not=lambda: nothing(edits.to_redo(), "redo"),
                says=lambda: said("Redo", edits.to_redo())),
        command("annotator", "Annotator …", "Set the name that your edits are stored under.",
                lambda: ask_for_text(context.docks.dialog_parent, "Annotator",
                                     "Name to store your edits under:",
                                     session.project.set_annotator,
                                     session.project.annotator or user()),
                icon="settings", section=True),
    ]  # fmt: skip


def register(context: Context) -> FileController:
    """Offer files and edits."""
    files = FileController(context)
    context.actions.add(_files(context, files, ImportController(context)))
    context.actions.add(_edits(context))
    changes, ask = context.session.changes, partial(_ask_where_recording_is, context)
    # the dialog comes when the message about it stands there already
    changes.hear(Part.RECORDING_MISSING, lambda path: changes.loop.post(partial(ask, path)))
    changes.hear(Part.MOVED, partial(_show_what_moved, context))
    # keys that follow an edit at once find them ready
    context.session.changes.watch(Part.EDITS, lambda: context.actions.refresh("&Edit"))
    return files
