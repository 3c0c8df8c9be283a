"""Opening and saving: dialogs, recent recordings and projects, what is dropped, the demo."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QMimeData, QObject, QSettings, Signal, Slot
from PySide6.QtWidgets import QFileDialog

from stereotrack_core.errors import InputError
from stereotrack_core.interop.run_file import read_run, write_run
from stereotrack_core.project.whereabouts import SUFFIX
from stereotrack_core.simulation.demo import DemoPlaces, demo_places, make_demo
from stereotrack_core.tracking.unfinished import INCOMPLETE

from ...services.failures import Message
from ...services.stored import stored_texts
from ...services.tasks.task import Task
from ...session.runs import RunEntry, entry_of_run
from ...shell.picture_file import write_picture
from ..report.report_work import ReportWork

if TYPE_CHECKING:
    from ...shell.main_window import MainWindow

_RECENT = "recent"
_MOST_RECENT = 10
_RUN_FILTER = "Complete run (*.npz);;Landmarks (*.csv);;OpenSim (*.trc);;C3D (*.c3d);;BVH (*.bvh)"


@dataclass(frozen=True)
class Asked:
    """What somebody wanted to see when opening, whatever was shown last."""

    frame: bool = False
    workspace: bool = False


class FileWork(QObject):
    """Everything between the window and the file system.

    Signals
    -------
    recent_changed : ()
    saved : Path
        A run was written.
    """

    recent_changed = Signal()
    saved = Signal(object)

    def __init__(self, window: MainWindow, settings: QSettings) -> None:
        super().__init__(window)
        self._window = window
        self._settings = settings
        self._demo_task: Task | None = None
        self._demo_places: DemoPlaces | None = None
        self._track_when_open = False
        self._run_when_open: Path | None = None
        self._project_when_open: Path | None = None
        self._workspace_when_open: str | None = None
        self.asked = Asked()
        self.reports = ReportWork(window)

    @property
    def making_demo(self) -> bool:
        """Whether the demo recording is being rendered."""
        return self._demo_task is not None

    @property
    def demo_run(self) -> Path | None:
        """Where the run of the demo that is open is kept."""
        return self._demo_places.run if self._demo_places is not None else None

    def recent(self) -> list[Path]:
        """Recordings and projects opened last that are still there, the newest first."""
        found = [Path(path) for path in stored_texts(self._settings, _RECENT) or ()]
        return [path for path in found if os.path.isdir(path) or is_project(path)]

    def ask_for_recording(self) -> None:
        """Let the person choose a recording folder."""
        recent = self.recent()
        start = str(recent[0].parent) if recent else str(Path.home())
        chosen = QFileDialog.getExistingDirectory(self._window, "Open a recording folder", start)
        if chosen:
            self.open(Path(chosen))

    def open(
        self, path: Path, *, frame: int = 0, workspace: str | None = None, run: Path | None = None
    ) -> None:
        """Open a recording folder, the folder of a recording.toml, or a project."""
        self._run_when_open, self._workspace_when_open = run, workspace
        self.asked = Asked(frame=frame != 0, workspace=workspace is not None)
        self._window.track.stop()
        if path.is_file() and path.name != "recording.toml":
            self._project_when_open = path.resolve()
            self._window.project.open_file(path, frame)
            return
        self._project_when_open = None
        self._window.project.give_up()
        self._window.document.open(path.parent if path.name == "recording.toml" else path, frame)

    def close_recording(self) -> None:
        """Go back to the welcome page."""
        self._window.track.stop()
        self._demo_places = None
        self._window.document.close()

    def begin_demo(self, folder: Path | None = None) -> None:
        """Make the demo recording unless it is there, open it and track it."""
        try:
            places = demo_places(folder)
        except InputError as error:
            self._window.show_error(error)
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

        self._demo_task = self._window.tasks.begin("rendering the demo", work, self._open_demo)
        self._demo_task.ended.connect(self._on_demo_ended)

    @Slot()
    def _on_demo_ended(self) -> None:
        self._demo_task = None
        self._window.actions_book.refresh()

    @Slot(object)
    def _open_demo(self, places: DemoPlaces) -> None:
        self._track_when_open = True
        self.open(places.recording, workspace="track")

    @Slot()
    def on_opened(self) -> None:
        """Do what was asked for together with opening; the window follows the recording already."""
        recording = self._window.document.recording
        if recording is None:
            return
        self._remember(self._project_when_open or recording.folder.resolve())
        run, self._run_when_open = self._run_when_open, None
        if run is not None:
            self.open_run(run)
        if self._workspace_when_open:
            self._window.show_workspace_named(self._workspace_when_open)
            self._workspace_when_open = None
        if self._track_when_open:
            self._track_when_open = False
            self._window.tracker.run()

    def _remember(self, folder: Path) -> None:
        others = [path for path in self.recent() if path != folder]
        paths = [str(path) for path in [folder, *others][:_MOST_RECENT]]
        self._settings.setValue(_RECENT, paths)
        self.recent_changed.emit()

    def ask_for_run(self) -> None:
        """Let the person choose a stored run."""
        chosen, _ = QFileDialog.getOpenFileName(
            self._window, "Open a run", "", "Run (*.npz *.part)"
        )
        if chosen:
            self.open_run(Path(chosen))

    def open_run(self, path: Path) -> None:
        """Show a stored run over the recording."""
        try:
            entry = entry_of_run(read_run(path), path)
        except InputError as error:
            self._window.show_error(error)
            return
        recording = self._window.document.recording
        assert entry.stored is not None  # noqa: S101 - it was read a moment ago
        made_of = entry.stored.meta.get("recording")
        if recording is not None and made_of not in {None, recording.name}:
            self._window.messages.show_message(
                Message(
                    "warning",
                    f"this run was tracked in the recording {made_of}, not in {recording.name}",
                    path.name,
                    "Its curves may mean nothing here.",
                )
            )
        if entry.stored.meta.get(INCOMPLETE):
            self._window.messages.show_message(
                Message(
                    "note",
                    f"this run was stopped after {len(entry.frames)} frames",
                    path.name,
                    "Where its file .part is there, `stereotrack track --resume` goes on with it.",
                )
            )
        self._window.runs.add(entry)

    def ask_where_to_save(self) -> None:
        """Let the person choose where the active run is kept."""
        active = self._window.runs.active
        if active is None:
            return
        name = active.path or Path("run.npz")
        chosen, _ = QFileDialog.getSaveFileName(
            self._window, "Save the run", str(name), _RUN_FILTER
        )
        if chosen:
            self.save_run(active, Path(chosen))

    def save_run(self, entry: RunEntry, path: Path) -> None:
        """Write a run; says so when it is done."""
        run = entry.run()
        if run is None:
            return
        path = path if path.suffix else path.with_suffix(".npz")
        try:
            write_run(path, run)
        except (InputError, OSError) as error:
            self._window.show_error(error)
            return
        entry.path = path
        self._window.statusBar().showMessage(f"The run was saved as {path}.", 6000)
        self.saved.emit(path)

    def ask_for_picture(self) -> None:
        """Let the person choose where a picture of the window is kept."""
        picture = self._window.grab()
        chosen, _ = QFileDialog.getSaveFileName(
            self._window, "Save a picture of the window", "stereotrack.png", "PNG (*.png)"
        )
        if not chosen:
            return
        path = Path(chosen)
        try:
            write_picture(path if path.suffix else path.with_suffix(".png"), picture)
        except InputError as error:
            self._window.show_error(error)


def is_project(path: Path) -> bool:
    """Whether a path looks like a project file."""
    return path.suffix == SUFFIX and os.path.isfile(path)


def dropped_path(data: QMimeData) -> Path | None:
    """Recording folder, recording.toml or project that was dragged into the window."""
    for url in data.urls():
        path = Path(url.toLocalFile())
        if not url.isLocalFile():
            continue
        if path.is_dir() or path.name == "recording.toml" or is_project(path):
            return path
    return None
