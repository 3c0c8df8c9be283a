"""Keypoints that 2-D detectors have predicted, as the open project keeps them."""

from collections.abc import Callable, Mapping
from functools import partial

from stereotrack_core.pose_model.detect import DETECTOR_NAME
from stereotrack_core.pose_model.installation import is_installed
from stereotrack_core.project.detectors import DetectorImport, removal
from stereotrack_core.project.predictions import DetectorState
from stereotrack_core.project.project import Project
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.keypoints import Keypoints, keypoints_of
from stereotrack_core.tracking.parameters import Settings

from .base import Base
from .changes import Part
from .edits import WindowEdit
from .jobs import Job, Task
from .project import ProjectPresenter
from .runs import RunEntry


class KeypointPresenter:
    """Knows which detectors the project has keypoints of; imports and removals are edits."""

    def __init__(self, base: Base, project: ProjectPresenter) -> None:
        self._tell, self._tasks = base.changes.tell, base.tasks
        self._project, self._edits = project, base.edits
        self._known: tuple[Mapping[str, int], tuple[str, ...]] | None = None
        self._frame: tuple[int, Keypoints] | None = None
        self._all: Keypoints | None = None
        self._detected: tuple[range, Keypoints] | None = None
        self.wanted = True  # whether runs and trials are tracked with them

    @property
    def sources(self) -> Mapping[str, int]:
        return self._read()[0]

    @property
    def cameras(self) -> tuple[str, ...]:
        return self._read()[1]

    def for_run(self, settings: Settings, frames: range) -> Keypoints | None:
        """Keypoints that a run of these frames is tracked with; None if there are none.

        The project's keypoints of the installed detector are left out unless they are of every
        frame: the tracker asks the same detector itself, in all frames.
        """
        if not settings.follows_data:
            return None
        known = self._of_project()
        asks = settings.uses_detector and is_installed()
        if known is not None and asks and set(self.sources) == {DETECTOR_NAME}:
            known = known if set(frames) <= set(known.frame.tolist()) else None
        if known is None and self._detected is not None and self._detected[0] == frames:
            return self._detected[1]
        return known

    def for_trial(self, settings: Settings, frames: range) -> Keypoints | None:
        """Keypoints that a trial is tracked with: in mono views those of a run, if need be."""
        known = self.for_run(settings, frames)
        if known is None and self._detected is not None and settings.follows_data:
            return self._detected[1]
        return known

    def _of_project(self) -> Keypoints | None:
        project = self._project.project
        if project is None or not (self.wanted and self.cameras):
            return None
        if self._all is None:
            self._all = project.keypoints.all()
        return self._all

    def remember(self, frames: range, keypoints: Keypoints) -> None:
        """Keep what a run has detected in mono views, for trials and until the project changes."""
        if self._detected is None or self._detected[1] is not keypoints:
            self._detected, self._frame = (frames, keypoints), None
            self._tell(Part.KEYPOINTS)

    def take_of(self, entry: RunEntry | None) -> None:
        """Take what a run has detected in mono views, when it comes back."""
        run = None if entry is None else entry.stored
        if entry is None or run is None or run.keypoints is None:
            return
        if (run.meta.get("keypoints") or {}).get("sources") == [DETECTOR_NAME]:
            self.remember(entry.wanted, run.keypoints)

    @property
    def drawn(self) -> bool:
        return bool(self.cameras) or self._detected is not None

    def mono_views(self, recording: Recording) -> tuple[str, ...]:
        """Mono views with keypoints to track by; none where any view gives depth."""
        known = set(self.cameras if self.wanted else ())
        if self._detected is not None:
            known |= set(self._detected[1].cameras)
        if any(view.kind != "mono" for view in recording.views):
            return ()
        return tuple(view.name for view in recording.views if view.image.camera in known)

    def why_none(self) -> str:
        how = "Import those of a detector with File, Import predictions."
        return "" if self.cameras else f"The project has no keypoints. {how}"

    def toggle(self) -> None:
        self.wanted = not self.wanted
        self._tell(Part.KEYPOINTS)

    def at(self, frame: int) -> Keypoints | None:
        """Keypoints of a frame, the project's or those of a run; None if there are none at all."""
        project = self._project.project
        if project is None or not self.drawn:
            return None
        if self._frame is None or self._frame[0] != frame:
            own = project.keypoints.at(frame) if self.cameras else None
            if not own and self._detected is not None:
                own = self._detected[1][self._detected[1].frame == frame]
            self._frame = frame, own if own is not None else keypoints_of(())
        return self._frame[1]

    def write(
        self,
        project: Project,
        words: str,
        make: Callable[[], tuple[DetectorState, DetectorState]],
        done: Callable[[], object],
    ) -> Task:
        """Change in the background what the project keeps of some detectors; an edit.

        `make` gives what it keeps before and afterwards, `done` is called when that is written.
        """

        def work(_task: Task) -> tuple[DetectorState, DetectorState]:
            states = make()
            project.keypoints.put(states[1])
            return states

        def written(states: tuple[DetectorState, DetectorState]) -> None:
            if project is self._project.project:
                self._edits.add(WindowEdit(words, partial(self._put, project), *states, "annotate"))
                self._read_again()
                done()

        return self._tasks.write(Job(words, work, written))

    def _put(self, project: Project, state: DetectorState) -> None:
        """Undo or redo in the background, in the order of all that is written."""
        words, keypoints = "saving predictions", project.keypoints
        self._tasks.write(Job(words, lambda _: keypoints.put(state), ended=self._read_again))

    def bring(self, project: Project, plan: DetectorImport, done: Callable[[], object]) -> Task:
        """Write an import; see :meth:`write`."""
        words = f"import predictions of {', '.join(plan.after.sources)}"
        return self.write(project, words, lambda: (plan.before, plan.after), done)

    def remove(self, source: str, done: Callable[[], object] = lambda: None) -> None:
        """Remove a detector's keypoints and proposals; see :meth:`write`."""
        project = self._project.project
        if project is not None:
            words = f"remove predictions of {source}"
            self.write(project, words, lambda: removal(project, source), done)

    def _read(self) -> tuple[Mapping[str, int], tuple[str, ...]]:
        """What is known of the open project, which is asked once."""
        project = self._project.project
        if project is None:
            return {}, ()
        if self._known is None:
            self._known = project.keypoints.sources(), project.keypoints.cameras()
        return self._known

    def on_project(self) -> None:
        """Forget what belongs to another project."""
        self._detected = None
        self._read_again()

    def _read_again(self) -> None:
        self._known = self._frame = self._all = None
        self._tell(Part.KEYPOINTS)
