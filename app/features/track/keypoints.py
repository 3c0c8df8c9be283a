"""Keypoints of the project, with which runs are tracked unless a person says otherwise."""

from __future__ import annotations

from PySide6.QtCore import QObject

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
        session.track.keypoints_for_run = self.for_run

    def for_run(self) -> Keypoints | None:
        """What the next run is tracked with; None where that is nothing."""
        used = self._session.track.settings.tracking.matching == "data_to_model"
        return self._session.keypoints.all() if used and self.wanted else None

    def why_none(self) -> str:
        """Why no run can use keypoints, as a sentence."""
        none = (
            "The project has no keypoints. Import those of a detector with File, Import "
            "predictions."
        )
        return self._session.no_project() or ("" if self._session.keypoints.cameras else none)

    def why_not_tracked(self) -> str:
        """Why nothing can be tracked: there is neither depth nor a keypoint in its place."""
        recording = self._session.document.recording
        ready = recording is not None and not recording.guessed and not self._session.no_frames()
        if ready and self.wanted and len(self._session.keypoints.cameras) >= _FEWEST_VIEWS:
            return ""
        return self._session.no_depth()

    def toggle(self) -> None:
        """Use them for the next run, or do not."""
        self.wanted = not self.wanted
