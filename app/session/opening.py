"""Opening recordings and projects: what was asked for, and which were opened last."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import QMimeData, QObject, QSettings, Signal

from stereotrack_core.project.whereabouts import SUFFIX

from ..services.stored import stored_texts
from .document import DocumentPresenter
from .project import ProjectPresenter
from .tracking import TrackPresenter

_RECENT = "recent"
_MOST_RECENT = 10


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

    def __init__(
        self,
        document: DocumentPresenter,
        project: ProjectPresenter,
        track: TrackPresenter,
        settings: QSettings,
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self._document, self._project, self._track = document, project, track
        self._settings = settings
        self.asked = self._due = Asked()
        document.opened.connect(self._remember)

    def recent(self) -> list[Path]:
        """Recordings and projects opened last that are still there, the newest first."""
        found = [Path(path) for path in stored_texts(self._settings, _RECENT) or ()]
        return [path for path in found if os.path.isdir(path) or is_project(path)]

    def open(
        self,
        path: Path,
        *,
        frame: int = 0,
        workspace: str | None = None,
        run: Path | None = None,
        tracks: bool = False,
    ) -> None:
        """Open a recording folder, the folder of a recording.toml, or a project."""
        named = path.is_file() and path.name != "recording.toml"
        project = path.resolve() if named else None
        self.asked = self._due = Asked(project, frame, workspace or "", run, tracks)
        self._track.stop()
        if named:
            self._project.open_file(path, frame)
            return
        self._project.give_up()
        self._document.open(path.parent if path.name == "recording.toml" else path, frame)

    def due(self) -> Asked:
        """What was asked for and is still to be done, once."""
        due, self._due = self._due, Asked()
        return due

    def _remember(self) -> None:
        recording = self._document.recording
        if recording is None:
            return
        opened = self.asked.project or recording.folder.resolve()
        others = [path for path in self.recent() if path != opened]
        paths = [str(path) for path in [opened, *others][:_MOST_RECENT]]
        self._settings.setValue(_RECENT, paths)
        self.recent_changed.emit()


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
