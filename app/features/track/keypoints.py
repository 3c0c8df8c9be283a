"""Keypoints of the project, with which runs are tracked unless a person says otherwise."""

from __future__ import annotations

from PySide6.QtCore import QObject, Slot

from stereotrack_core.project.project import Project
from stereotrack_core.recording.keypoints import Keypoints

from ...session.session import Session

_FEWEST_VIEWS = 2
"""Mono views with keypoints that can be tracked without depth."""


class RunKeypoints(QObject):
    """Knows whether the open project has keypoints, and hands them to the next run."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self.wanted = True
        """Whether the next run uses them."""
        self._known: tuple[Project, tuple[str, ...]] | None = None
        session.project.closed.connect(self._forget)
        session.track.keypoints_for_run = self.for_run

    def for_run(self) -> Keypoints | None:
        """What the next run is tracked with; None where that is nothing."""
        project = self._session.project.project
        used = self._session.track.settings.tracking.matching == "data_to_model"
        if project is None or not (used and self.wanted and self._cameras()):
            return None
        return project.keypoints.all()

    def why_none(self) -> str:
        """Why no run can use keypoints, as a sentence."""
        none = (
            "The project has no keypoints. Import those of a detector with `stereotrack import "
            "predictions` while the project is closed."
        )
        return self._session.no_project() or ("" if self._cameras() else none)

    def why_not_tracked(self) -> str:
        """Why nothing can be tracked: there is neither depth nor a keypoint in its place."""
        recording = self._session.document.recording
        ready = recording is not None and not recording.guessed and not self._session.no_frames()
        if ready and self.wanted and len(self._cameras()) >= _FEWEST_VIEWS:
            return ""
        return self._session.no_depth()

    def toggle(self) -> None:
        """Use them for the next run, or do not."""
        self.wanted = not self.wanted

    def _cameras(self) -> tuple[str, ...]:
        """Cameras with keypoints; the project is asked once, as only commands write them."""
        project = self._session.project.project
        if project is None:
            return ()
        if self._known is None or self._known[0] is not project:
            self._known = project, project.keypoints.cameras()
        return self._known[1]

    @Slot()
    def _forget(self) -> None:
        self._known = None
