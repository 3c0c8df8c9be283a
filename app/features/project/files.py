"""Opening and saving: dialogs, stored runs, the demo."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject, Slot

from stereotrack_core.errors import InputError
from stereotrack_core.interop.run_file import read_run, write_run
from stereotrack_core.simulation.make import DemoPlaces, demo_places, make_demo
from stereotrack_core.tracking.unfinished import INCOMPLETE

from ...context import Context
from ...services.tasks.task import Task
from ...session.runs import RunEntry, entry_of_run
from ...widgets.forms.form_dialog import ask_for_folder, ask_to_open, ask_to_save
from ...widgets.forms.message import Message

_RUN_FILTER = "Complete run (*.npz);;Landmarks (*.csv);;OpenSim (*.trc);;C3D (*.c3d);;BVH (*.bvh)"


class FileController(QObject):
    """Everything between the window and the file system."""

    def __init__(self, context: Context) -> None:
        super().__init__(context.session)
        self._context, self._session = context, context.session
        self._demo_task: Task | None = None
        self._demo_places: DemoPlaces | None = None
        context.session.ready.connect(self._on_ready)

    @property
    def making_demo(self) -> bool:
        """Whether the demo recording is being rendered."""
        return self._demo_task is not None

    @property
    def demo_run(self) -> Path | None:
        """Where the run of the demo that is open is kept."""
        return self._demo_places.run if self._demo_places is not None else None

    def ask_for_recording(self) -> None:
        """Let the person choose a recording folder."""
        recent = self._session.opening.recent()
        start = str(recent[0].parent) if recent else str(Path.home())
        parent = self._context.docks.dialog_parent
        ask_for_folder(parent, "Open a recording folder", start, self._session.opening.open)

    def close_recording(self) -> None:
        """Go back to the welcome page."""
        self._session.track.stop()
        self._demo_places = None
        self._session.document.close()

    def begin_demo(self, folder: Path | None = None) -> None:
        """Make the demo recording unless it is there, open it and track it."""
        try:
            places = demo_places(folder)
        except InputError as error:
            self._context.notifier.error(error)
            return
        self._demo_places = places
        if places.made:
            self._open_demo(places)
            return

        def work(task: Task) -> DemoPlaces:
            make_demo(
                places,
                on_progress=lambda done, of: task.report(done / of, f"frame {done} of {of}"),
                cancelled=task.token.cancelled,
            )
            return places

        self._demo_task = self._context.tasks.begin("rendering the demo", work, self._open_demo)
        self._demo_task.ended.connect(self._on_demo_ended)

    @Slot()
    def _on_demo_ended(self) -> None:
        self._demo_task = None
        self._context.actions.refresh()

    @Slot(object)
    def _open_demo(self, places: DemoPlaces) -> None:
        self._session.opening.open(places.recording, workspace="track", tracks=True)

    @Slot()
    def _on_ready(self) -> None:
        """Do what was asked for together with opening."""
        asked = self._session.opening.due()
        if asked.run is not None:
            self.open_run(asked.run)
        if asked.workspace:
            self._context.docks.show_named(asked.workspace)
        if asked.tracks:
            self._session.tracker.run()

    def ask_for_run(self) -> None:
        """Let the person choose a stored run."""
        parent = self._context.docks.dialog_parent
        ask_to_open(parent, "Open a run", "", "Run (*.npz *.part)", self.open_run)

    def open_run(self, path: Path) -> None:
        """Show a stored run over the recording."""
        try:
            entry = entry_of_run(read_run(path), path)
        except InputError as error:
            self._context.notifier.error(error)
            return
        recording = self._session.document.recording
        assert entry.stored is not None  # noqa: S101 - it was read a moment ago
        made_of = entry.stored.meta.get("recording")
        if recording is not None and made_of not in {None, recording.name}:
            self._context.notifier.show(
                Message(
                    "warning",
                    f"this run was tracked in the recording {made_of}, not in {recording.name}",
                    path.name,
                    "Its curves may be meaningless here.",
                )
            )
        if entry.stored.meta.get(INCOMPLETE):
            self._context.notifier.show(
                Message(
                    "note",
                    f"this run was stopped after {len(entry.frames)} frames",
                    path.name,
                    "If its .part file still exists, `stereotrack track --resume` continues the "
                    "run.",
                )
            )
        self._session.runs.add(entry)

    def ask_where_to_save(self) -> None:
        """Let the person choose where the active run is kept."""
        active = self._session.runs.active
        if active is None:
            return
        parent, name = self._context.docks.dialog_parent, active.path or Path("run.npz")
        ask_to_save(parent, "Save run", name, _RUN_FILTER, partial(self.save_run, active))

    def save_run(self, entry: RunEntry, path: Path) -> None:
        """Write a run; says so when it is done."""
        run = entry.run()
        if run is None:
            return
        path = path if path.suffix else path.with_suffix(".npz")
        if self._context.notifier.attempt(lambda: write_run(path, run)):
            entry.path = path
            self._context.notifier.say(f"Run saved to {path}.", 6000)
