"""Open what a person names: recordings, projects, runs, videos; and what was opened last."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import QMimeData, QSettings

from stereotrack_core.interop.run_file import holds_run
from stereotrack_core.interop.run_places import is_run_of, recording_of_run_file
from stereotrack_core.project.whereabouts import SUFFIX
from stereotrack_core.recording.folder import DESCRIPTION
from stereotrack_core.recording.importing.sources import is_media, is_unmade
from stereotrack_core.study.description import SUFFIX as STUDY_SUFFIX

from ..services.layout import stored_texts
from ..services.tasks.task import CancelToken, Task, TaskList
from .changes import Part, TellChange
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
    frame: int = 0
    workspace: str = ""  # its name; empty for the one that was shown last
    run: Path | None = None
    tracks: bool = False


class Opening:
    """Opens what a person names, and remembers it.

    Attributes
    ----------
    asked : Asked
        What was asked for last.
    """

    def __init__(
        self,
        tell_change: TellChange,
        document: DocumentPresenter,
        project: ProjectPresenter,
        track: TrackPresenter,
        tasks: TaskList,
        settings: QSettings,
    ) -> None:
        self._tell_change = tell_change
        self._document, self._project, self._track = document, project, track
        self._tasks, self._settings = tasks, settings
        self._finding: CancelToken | None = None
        self._ended = False
        self.asked = self._due = Asked()

    def recents(self) -> list[Path]:
        """Recordings and projects opened last that are still there, the newest first."""
        known = [Path(path) for path in stored_texts(self._settings, _PATHS) or ()]
        return [path for path in known if os.path.isdir(path) or is_project(path)]

    def forget_recents(self) -> None:
        self._settings.setValue(_PATHS, [])
        self._tell_change(Part.RECENT)

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

        Of a folder of videos, or a video, a recording can be made.
        """
        if self._ended:
            return
        self._finding = None
        if path.name.endswith(STUDY_SUFFIX) and path.is_file():
            self._tell_change(Part.STUDY_WANTED, path)
            return
        if path.is_file() and holds_run(path):
            self._open_run(path, frame, workspace)
            return
        if is_unmade(path):
            self._tell_change(Part.IMPORT_WANTED, (path,))
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
            self._tell_change(Part.IMPORT_WANTED, media)

    def due(self) -> Asked:
        """What was asked for and is still to be done, once."""
        due, self._due = self._due, Asked()
        return due

    def _open_run(self, path: Path, frame: int, workspace: str | None) -> None:
        """Look for the recording of a run, off the window's thread, and open it with the run."""
        shown = self._document.recording

        def find(_task: Task) -> Path | None:
            of_shown = shown is not None and is_run_of(path, shown)
            return shown.folder if shown and of_shown else recording_of_run_file(path)

        def take(folder: Path | None) -> None:
            if token is not self._finding:  # something else was asked for since
                return
            now = self._document.recording
            if now is not None and (folder is None or now.folder.resolve() == folder.resolve()):
                # what does not belong to it is said there
                self._tell_change(Part.RUN_WANTED, path)
            elif folder is None:
                self._tell_change(Part.RUN_ALONE, path)
            else:
                self.open(folder, frame=frame, workspace=workspace, run=path)

        title = f"looking for the recording of {path.name}"
        self._finding = token = self._tasks.begin(title, find, take).token

    def remember(self) -> None:
        """Put the recording that is open, or its project, first in the list of what was opened."""
        recording = self._document.recording
        if recording is None:
            return
        opened = self.asked.project or recording.folder.resolve()
        others = [path for path in self.recents() if path != opened]
        self._settings.setValue(_PATHS, [str(path) for path in (opened, *others)][:MOST_RECENT])
        self._tell_change(Part.RECENT)


def dropped_paths(data: QMimeData) -> tuple[Path, ...]:
    """Folders, projects, runs, studies, videos and images that were dragged into the window."""

    def opens(path: Path) -> bool:
        named = path.name == DESCRIPTION or path.name.endswith(STUDY_SUFFIX)
        known = path.is_dir() or named or is_project(path) or is_media(path)
        return known or (path.is_file() and holds_run(path))

    paths = [Path(url.toLocalFile()) for url in data.urls() if url.isLocalFile()]
    return tuple(path for path in paths if opens(path))
