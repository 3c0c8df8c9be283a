"""Open what a person names: recordings, projects, runs, videos; and what was opened last."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import QMimeData, QObject, QSettings, Signal, Slot

from stereotrack_core.interop.run_file import holds_run
from stereotrack_core.interop.run_places import is_run_of, recording_of_run_file
from stereotrack_core.project.whereabouts import SUFFIX
from stereotrack_core.recording.folder import DESCRIPTION
from stereotrack_core.recording.importing.sources import is_media, is_unmade
from stereotrack_core.study.description import SUFFIX as STUDY_SUFFIX

from ..services.layout import stored_texts
from ..services.tasks.task import Task, TaskList
from .document import DocumentPresenter
from .project import ProjectPresenter
from .tracking import TrackPresenter

_PATHS = "recent"
MOST_RECENT = 10


def is_project(path: Path) -> bool:
    """Whether a path looks like a project file."""
    return path.suffix == SUFFIX and os.path.isfile(path)


@dataclass(frozen=True)
class Asked:
    """What somebody wanted to see when opening, whatever was shown last."""

    project: Path | None = None
    """The project file that was named."""
    frame: int = 0
    workspace: str = ""
    """Its name; empty for the one that was shown last."""
    run: Path | None = None
    """A run to be shown."""
    tracks: bool = False
    """Whether to track it at once."""


class Opening(QObject):
    """Opens what a person names, and remembers it.

    Attributes
    ----------
    asked : Asked
        What was asked for last.
    """

    recent_changed = Signal()
    import_wanted = Signal(object)
    """Folders and files of videos or images, of which a recording can be made."""
    study_wanted = Signal(object)
    """A study file; the recording that is open stays."""
    run_wanted = Signal(object)
    """A run of the recording that is open already."""
    run_without_recording = Signal(object)
    """A run whose recording was not found; the person has to say where it is."""

    def __init__(
        self,
        document: DocumentPresenter,
        project: ProjectPresenter,
        track: TrackPresenter,
        tasks: TaskList,
        settings: QSettings,
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self._document, self._project, self._track = document, project, track
        self._tasks, self._settings = tasks, settings
        self._finding: Task | None = None
        self._ended = False
        self.asked = self._due = Asked()
        document.opened.connect(self._remember)

    def recents(self) -> list[Path]:
        """Recordings and projects opened last that are still there, the newest first."""
        known = [Path(path) for path in stored_texts(self._settings, _PATHS) or ()]
        return [path for path in known if os.path.isdir(path) or is_project(path)]

    def forget_recents(self) -> None:
        """Empty the list of what was opened last."""
        self._settings.setValue(_PATHS, [])
        self.recent_changed.emit()

    def open(
        self,
        path: Path,
        *,
        frame: int = 0,
        workspace: str | None = None,
        run: Path | None = None,
        tracks: bool = False,
    ) -> None:
        """Open a recording folder, the folder of a recording.toml, a project, a run, or a study.

        Of a folder of videos, or a video, a recording can be made: :attr:`import_wanted`.
        """
        if self._ended:
            return
        self._finding = None
        if path.name.endswith(STUDY_SUFFIX) and path.is_file():
            self.study_wanted.emit(path)
            return
        if path.is_file() and holds_run(path):
            self._open_run(path, frame, workspace)
            return
        if is_unmade(path):
            self.import_wanted.emit((path,))
            return
        named = path.is_file() and path.name != DESCRIPTION
        project = path.resolve() if named else None
        self.asked = self._due = Asked(project, frame, workspace or "", run, tracks)
        self._track.stop()
        if named:
            self._project.open_file(path, frame)
            return
        self._project.give_up()
        self._document.open(path.parent if path.name == DESCRIPTION else path, frame)

    def end(self) -> None:
        """Open nothing any more, whatever is found or made from now on: the window closes."""
        self._ended = True

    def open_all(self, paths: Sequence[Path]) -> None:
        """Open what was dropped: several videos or folders of them together make a recording."""
        media = tuple(path for path in paths if is_unmade(path))
        others = [path for path in paths if path not in media]
        if others:
            self.open(others[0])
        elif media:
            self.import_wanted.emit(media)

    def due(self) -> Asked:
        """What was asked for and is still to be done, once."""
        due, self._due = self._due, Asked()
        return due

    def _open_run(self, path: Path, frame: int, workspace: str | None) -> None:
        """Look for the recording of a run, off the window's thread, and open it with the run."""
        shown = self._document.recording

        def find(_task: Task) -> tuple[Path, int, str | None, Path | None]:
            of_shown = shown is not None and is_run_of(path, shown)
            folder = shown.folder if shown and of_shown else recording_of_run_file(path)
            return path, frame, workspace, folder

        title = f"looking for the recording of {path.name}"
        self._finding = self._tasks.begin(title, find, self._on_found)

    @Slot(object)
    def _on_found(self, found: tuple[Path, int, str | None, Path | None]) -> None:
        if self.sender() is not self._finding:  # something else was asked for since
            return
        path, frame, workspace, folder = found
        shown = self._document.recording
        if shown is not None and (folder is None or shown.folder.resolve() == folder.resolve()):
            self.run_wanted.emit(path)  # what does not belong to it is said there
        elif folder is None:
            self.run_without_recording.emit(path)
        else:
            self.open(folder, frame=frame, workspace=workspace, run=path)

    @Slot()
    def _remember(self) -> None:
        recording = self._document.recording
        if recording is None:
            return
        opened = self.asked.project or recording.folder.resolve()
        others = [path for path in self.recents() if path != opened]
        self._settings.setValue(_PATHS, [str(path) for path in (opened, *others)][:MOST_RECENT])
        self.recent_changed.emit()


def dropped_paths(data: QMimeData) -> tuple[Path, ...]:
    """Folders, projects, runs, studies, videos and images that were dragged into the window."""
    paths = [Path(url.toLocalFile()) for url in data.urls() if url.isLocalFile()]
    return tuple(path for path in paths if path.is_dir() or _opens(path))


def _opens(path: Path) -> bool:
    known = path.name == DESCRIPTION or is_project(path) or is_media(path)
    known |= path.name.endswith(STUDY_SUFFIX)
    return known or (path.is_file() and holds_run(path))
