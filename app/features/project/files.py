"""Opening and saving: dialogs, stored runs, the demo."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject, Slot

from stereotrack_core.demo import DemoPlaces, copied_demo
from stereotrack_core.errors import InputError
from stereotrack_core.interop.run_file import read_run, write_run
from stereotrack_core.project.exporting.formats import ExportFormat, formats_of
from stereotrack_core.project.exporting.runs import Exported, export_run
from stereotrack_core.tracking.unfinished import INCOMPLETE

from ...context import Context
from ...services.tasks.task import Task
from ...session.opening import Opening
from ...session.runs import RunEntry, entry_of_run
from ...widgets.forms.form_dialog import ask_for_folder, ask_to_export, ask_to_open
from ...widgets.forms.message import Message


def recent_folder(opening: Opening) -> Path:
    """Folder of what was opened last, where dialogs start."""
    recent = opening.recents()
    return recent[0].parent if recent else Path.home()


class FileController(QObject):
    """Everything between the window and the file system."""

    def __init__(self, context: Context) -> None:
        super().__init__(context.session)
        self._context, self._session = context, context.session
        self._demo_places: DemoPlaces | None = None
        context.session.ready.connect(self._on_ready)
        opening = context.session.opening
        opening.run_wanted.connect(self.open_run)
        opening.run_without_recording.connect(self._ask_where_recording_is)
        opening.recent_changed.connect(self._list_recents)
        self.recents = tuple(opening.recents())
        """What was opened last, the newest first."""

    @property
    def demo_run(self) -> Path | None:
        """Where the run of the demo that is open is kept."""
        return self._demo_places.run if self._demo_places is not None else None

    def ask_for_recording(self) -> None:
        parent, opening = self._context.docks.dialog_parent, self._session.opening
        ask_for_folder(parent, "Open a recording folder", recent_folder(opening), opening.open)

    def close_recording(self) -> None:
        self._session.track.stop()
        self._demo_places = None
        self._context.tasks.after_writes(self._session.document.close)

    def begin_demo(self, folder: Path | None = None) -> None:
        """Copy the demo recording unless it is there, open it and track it."""

        def begin() -> None:
            self._demo_places = places = copied_demo(folder)
            self._session.opening.open(places.recording, workspace="track", tracks=True)

        self._context.notifier.attempt(begin)

    @Slot()
    def _on_ready(self) -> None:
        asked = self._session.opening.due()
        if asked.run is not None:
            self.open_run(asked.run)
        if asked.workspace:
            self._context.docks.show_named(asked.workspace)
        if asked.tracks:
            self._session.tracker.run()

    @Slot()
    def _list_recents(self) -> None:
        self.recents = tuple(self._session.opening.recents())
        self._context.actions.refresh_soon()

    def open_recent(self, place: int) -> None:
        if place < len(self.recents):
            self._session.opening.open(self.recents[place])

    # ---- runs

    @Slot(object)
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

    @Slot(object)
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
