"""Whether a camera contradicts the others, by all that is clicked; worked out beside the window."""

from collections.abc import Mapping
from functools import partial

from stereotrack_core.annotation import doubts
from stereotrack_core.errors import Finding
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.camera_agreement import Disagreement
from stereotrack_core.project.history import Changed
from stereotrack_core.project.project import Project

from .base import Base
from .changes import Part
from .jobs import LatestOnly
from .project import ProjectPresenter

_PAUSE_MS = 400


class CameraDoubts:
    """Follows the clicks of the project."""

    def __init__(self, base: Base, project: ProjectPresenter) -> None:
        self._changes, self._document = base.changes, base.document
        self._project = project
        self.now: Disagreement | None = None  # the camera that contradicts the others
        compare = "compare the cameras"
        self._worker = LatestOnly(base.tasks, lambda ask: ask(), compare, self._take)
        self._pause = base.later(self._ask, _PAUSE_MS)

    def settled(self) -> bool:
        return self._worker.settled() and not self._pause.isActive()

    def doubtful(self) -> tuple[str, ...]:
        return () if self.now is None else self.now.doubtful

    def findings(self) -> tuple[Finding, ...]:
        recording = self._document.recording
        if self.now is None or recording is None:
            return ()
        names = recording.camera_names()
        where = " and ".join(names.get(name, name) for name in self.doubtful())
        off, count = self.now.off, self.now.count
        what = f"{doubts.what_disagrees(self.now, names)} ({off} of {count} clicks lie off)"
        return (Finding("warning", where, what, doubts.what_to_do(self.now)),)

    def _ask(self) -> None:
        recording, project = self._document.recording, self._project.project
        if recording is None or recording.guessed or project is None:
            self._take(None, None)
        else:
            self._worker.ask(partial(_compared, project, recording.cameras))

    def _take(self, _question: object, found: Disagreement | None) -> None:
        if found != self.now:
            self.now = found
            self._changes.tell(Part.DOUBTS)

    def compare_soon(self, changed: Changed | None = None) -> None:
        """Compare again if an edit concerns clicks, or after another project was opened."""
        tables = {"click", "choice", "landmark_set", "camera_use"}
        if changed is None or changed.tables & tables:
            self._pause.start()

    def forget(self) -> None:
        """Know nothing any more: the project is about to be closed."""
        self._pause.stop()
        self._worker.close()
        self._take(None, None)


def _compared(project: Project, cameras: Mapping[str, Camera]) -> Disagreement | None:
    """Called in the worker's thread; the project may be closed meanwhile."""
    asked = sorted(doubts.frames_asked(project.clicks.frames()))
    clicks = [click for frame in asked for click in project.clicks.used(frame, frame + 1)]
    return doubts.doubtful_camera(clicks, cameras, project.landmark_set())
