"""Whether a camera contradicts the others, by all that is clicked; worked out beside the window."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

from PySide6.QtCore import QObject, Signal, Slot

from stereotrack_core.annotation.doubts import (
    doubtful_camera,
    frames_asked,
    residuals_by_camera,
    what_disagrees,
    what_to_do,
)
from stereotrack_core.errors import Finding
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.camera_agreement import CameraResidual, Disagreement
from stereotrack_core.project.history import Changed
from stereotrack_core.project.project import Project

from ..services.failures import Tell, message_of
from ..services.tasks.newest import LatestOnly
from ..widgets.redraw import later
from .document import DocumentPresenter
from .project import ProjectPresenter

_PAUSE_MS = 400


@dataclass(frozen=True, eq=False)
class _Question:
    project: Project
    cameras: Mapping[str, Camera]


_Answer: TypeAlias = tuple[Disagreement | None, tuple[CameraResidual, ...]]


class CameraDoubts(QObject):
    """Follows the clicks of the project."""

    changed = Signal()
    """Another camera does, or none, or by more or less; or cameras have other residuals."""

    def __init__(
        self, document: DocumentPresenter, project: ProjectPresenter, tell: Tell, parent: QObject
    ) -> None:
        super().__init__(parent)
        self._document, self._project = document, project
        self.now: Disagreement | None = None
        """The camera that contradicts the others."""
        self.residuals: tuple[CameraResidual, ...] = ()
        """How far the clicks of each camera lie from the points that the cameras agree on."""
        self._worker = LatestOnly(
            _answer,
            "compare the cameras",
            lambda _question, found: self._take(*found),
            lambda _question, error: tell(message_of(error)),
        )
        self._pause = later(self, self._ask, _PAUSE_MS)
        project.changed.connect(self._on_changed)
        project.opened.connect(self._pause.start)
        project.closing.connect(self._on_closing)

    def settled(self) -> bool:
        """Whether what is known is of the clicks as they are."""
        return self._worker.settled() and not self._pause.isActive()

    def close(self) -> None:
        """End the thread."""
        self._pause.stop()
        self._worker.close()

    def doubtful(self) -> tuple[str, ...]:
        """Names of the cameras that may be wrong."""
        return () if self.now is None else self.now.doubtful

    def findings(self) -> tuple[Finding, ...]:
        """What is known as a finding."""
        recording = self._document.recording
        if self.now is None or recording is None:
            return ()
        names = recording.camera_names()
        where = " and ".join(names.get(name, name) for name in self.doubtful())
        off, count = self.now.off, self.now.count
        what = f"{what_disagrees(self.now, names)} ({off} of {count} clicks lie off)"
        return (Finding("warning", where, what, what_to_do(self.now)),)

    @Slot()
    def _ask(self) -> None:
        recording, project = self._document.recording, self._project.project
        if recording is None or recording.guessed or project is None:
            self._take(None)
        else:
            self._worker.ask(_Question(project, recording.cameras))

    def _take(self, found: Disagreement | None, residuals: tuple[CameraResidual, ...] = ()) -> None:
        if (found, residuals) != (self.now, self.residuals):
            self.now, self.residuals = found, residuals
            self.changed.emit()

    @Slot(object)
    def _on_changed(self, changed: Changed) -> None:
        if changed.tables & {"click", "choice", "landmark_set"}:
            self._pause.start()

    @Slot()
    def _on_closing(self) -> None:
        self.close()
        self._take(None)


def _answer(question: _Question) -> _Answer:
    """Called in the worker's thread; the project may be closed meanwhile."""
    project = question.project
    asked = sorted(frames_asked(project.clicks.frames()))
    clicks = [click for frame in asked for click in project.clicks.at(frame)]
    known = clicks, question.cameras, project.landmark_set()
    found = doubtful_camera(*known)
    return found, residuals_by_camera(*known, found)
