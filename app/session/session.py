"""What is open and what is known about it, brought together."""

import dataclasses

from PySide6.QtCore import QObject, QSettings

from stereotrack_core.errors import InputError
from stereotrack_core.experiments.run_process import load
from stereotrack_core.pose_model.detect import DETECTOR_NAME
from stereotrack_core.pose_model.installation import is_installed
from stereotrack_core.project.history import Changed
from stereotrack_core.project.schema import CHOICE, SUBJECT
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.selection import gives_depth
from stereotrack_core.tracking.detecting import detects_first
from stereotrack_core.tracking.tuning.process import KeptRecording, forget

from ..services.failures import Tell, message_of
from ..services.tasks.task import Processes, Task, TaskList
from ..widgets.forms.message import Message
from .camera_doubts import CameraDoubts
from .changes import PROJECT, Changes, Part
from .document import DocumentPresenter
from .edits import EditStack
from .instant import CloudPresenter, InstantPresenter
from .judgement import JudgementPresenter
from .keypoints import KeypointPresenter
from .opening import Opening
from .project import ProjectPresenter
from .runs import RunList
from .tracker import TrackControl
from .tracking import TrackPresenter
from .view_state import ViewState

_FEWEST_VIEWS = 2  # mono views with keypoints that can be tracked without depth
_GUESSED = "Landmarks can be clicked. 3-D positions, fitting and tracking need a calibration."
_DETECTOR_HELPS = "The pose detector finds them, too: choose Track, Install pose detector …"


def unless(there: object, words: str) -> str:
    """Why something cannot be done, unless what it needs is there."""
    return "" if there else words


class Session(QObject):
    """The open recording with its project, its runs and what follows from them."""

    def __init__(
        self,
        changes: Changes,
        tell: Tell,
        tasks: TaskList,
        view_state: ViewState,
        settings: QSettings,
        processes: Processes | None = None,
    ) -> None:
        super().__init__(changes.parent())
        self.changes, self._tell, self._tasks = changes, tell, tasks
        self.view_state = view_state
        self.runs = RunList(changes.tell)
        self.document = DocumentPresenter(changes, tasks, tell, self._on_opened, self._on_closed)
        self.project = ProjectPresenter(changes, self.document, tasks, settings, tell)
        self.edits = EditStack(changes.tell, tell)
        """Everything that a person did, to be undone and redone in one order."""
        self.keypoints = KeypointPresenter(changes.tell, self.project, self.edits, tasks)
        self.clouds = CloudPresenter(changes.tell, tell)
        self.processes = processes or Processes()
        self._own_processes = processes is None
        self.kept: KeptRecording | None = None
        """What is open, for tasks that use the clouds of one another."""
        self.track = TrackPresenter(
            changes, self.project, self.runs, self.keypoints, self.processes.run, tell
        )
        self.opening = Opening(
            changes.tell, self.document, self.project, self.track, tasks, settings
        )
        self.judging = JudgementPresenter(changes, self.document, self.runs, tell)
        self.cameras = CameraDoubts(changes, self.document, self.project, tell)
        """Whether a camera contradicts the others."""
        self.instant = InstantPresenter(self)
        self.tracker = TrackControl(self.document, self.runs, self.track, view_state, self.edits)
        self.clouds.parameters = self.track.settings.depth
        self._follow()
        tasks.watch(self.settled)

    def _follow(self) -> None:
        """Let the parts follow one another, in this order and before all features."""
        watch, hear = self.changes.watch, self.changes.hear
        # what undo does next is known before anybody asks for it, and so is the subject
        hear(Part.EDIT, self.edits.follow)
        hear(Part.EDIT, self._on_edited)
        watch(PROJECT, self._on_project)
        # keypoints of another project come before what is drawn and tracked with them
        watch(PROJECT, self.keypoints.on_project)
        # runs are judged, and drawn, before panels ask how good they are
        watch(Part.RUN_FRAMES, self.judging.judge_soon)
        watch(Part.RUNS | Part.ACTIVE_RUN | Part.RUN_ENDED, self.judging.judge)
        hear(Part.EDIT, self.cameras.compare_soon)
        watch(Part.PROJECT_OPENED, self.cameras.compare_soon)
        watch(Part.PROJECT_CLOSING, self.cameras.forget)
        watch(Part.KEYPOINTS | Part.CLOUD | Part.STEP | Part.DISPLAY, self.instant.tell_soon)
        watch(Part.IMAGES, self.instant.tell)
        watch(Part.RUNS | Part.ACTIVE_RUN, self.instant.on_runs)
        hear(Part.TRACKED, self.instant.on_tracked)
        hear(Part.RESTED, self.instant.keep)
        watch(Part.TRACKING, self.instant.on_tracking)
        # the frame that the tracker is at is shown when its cloud is kept
        hear(Part.TRACKED, self.tracker.on_tracked)
        watch(Part.KEYPOINTS, self._on_subject)
        watch(Part.SETTINGS, self._on_settings)
        watch(Part.ACTIVE_RUN, self._take_detected)

    def settled(self) -> bool:
        parts = (self.document, self.judging, self.cameras, self.instant)
        return not self.track.running and all(part.settled() for part in parts)

    def close(self) -> None:
        """End all work and close what is open, with the window."""
        self.opening.end()
        self.document.pause()
        self.track.stop(at_once=True)
        self.changes.tell(Part.LEAVING)
        if self._own_processes:
            self.processes.close()
        self._tasks.shutdown()
        self.document.close()
        self.changes.tell(Part.WINDOW_CLOSING)
        self.cameras.close()
        self.judging.close()
        self.project.close()
        self.project.give_up()
        self.clouds.set_recording(None)

    # ---- why something cannot be done now, in sentences

    def no_recording(self) -> str:
        if self.document.opening:
            return "The recording is still loading."
        return unless(self.document.recording is not None, "No recording is open. Open one first.")

    def no_project(self) -> str:
        return self.no_recording() or unless(self.project.project, self.project.why_no_edit())

    def no_edit(self) -> str:
        return self.no_recording() or self.project.why_no_edit()

    def no_frames(self) -> str:
        none = "The recording has no frames. See Recording checks."
        return self.no_recording() or unless(self.document.frame_count, none)

    def no_depth(self) -> str:
        recording = self.document.recording
        if recording is not None and recording.guessed:
            return "The calibration is a guess. Replace it with a calibration of these cameras."
        none = "This needs depth, which no view of this recording provides."
        return self.no_frames() or unless(self.clouds.available, none)

    def not_tracked(self) -> str:
        """Nothing can be tracked: there is neither depth nor keypoints in its place."""
        reason, recording = self.no_depth(), self.document.recording
        if not reason or recording is None or recording.guessed or self.no_frames():
            return reason
        detects = detects_first(recording, self.track.settings)
        views = recording.views if detects else self.keypoints.mono_views(recording)
        if len(views) >= _FEWEST_VIEWS:
            return ""
        none = (
            "No view of this recording provides depth. Tracking needs a stereo or depth view, or "
            "keypoints of two mono views: use File, Import predictions."
        )
        return none if is_installed() else f"{none} {_DETECTOR_HELPS}"

    def not_tried(self) -> str:
        """Neither trials nor single steps can be tracked: nobody has seen any keypoints yet."""
        recording, frame = self.document.recording, self.document.frame
        reason = self.not_tracked()
        if reason or recording is None or gives_depth(recording):
            return reason
        known = self.keypoints.for_trial(self.track.settings, range(frame, frame + 1))
        none = "No keypoints are known here. Run the tracker first: it detects them in the views."
        return unless(known is not None, none)

    def no_run(self) -> str:
        none, active = "There is no run yet. Run the tracker or open a run.", self.runs.active
        return self.no_recording() or unless(active is not None and active.frames, none)

    def tracker_works(self) -> str:
        return unless(not self.track.running, "The tracker is running. Pause it first.")

    # ---- following

    def _take_detected(self) -> None:
        """Keypoints that the active run detected in mono views come back with it."""
        entry, recording = self.runs.active, self.document.recording
        run = None if entry is None else entry.stored
        if entry is None or run is None or run.keypoints is None or recording is None:
            return
        if (run.meta.get("keypoints") or {}).get("sources") == [DETECTOR_NAME]:
            self.keypoints.remember(entry.wanted, run.keypoints)

    def _on_opened(self) -> None:
        refused, recording = None, self.document.recording
        if recording is not None:  # the tracker never sees the truth
            self._keep_recording(recording)
            self.view_state.show_views(recording.views)
        try:
            measured = recording is not None and not recording.guessed
            self.clouds.set_recording(recording if measured else None)
        except InputError as error:
            self.clouds.set_recording(None)
            refused = error
        self.changes.tell(Part.RECORDING_OPENED)
        self.changes.tell(Part.READY)
        if self.clouds.available:
            process = self.processes.run  # a task that lasts refers to nothing of the window
            Task("starting the process that tracks", lambda _: process(load)).start()
        if refused is not None:
            self._tell(message_of(refused))
        if recording is not None and recording.guessed:
            what = "the cameras of this recording are guessed from the size of the images"
            self._tell(Message("note", what, recording.name, _GUESSED))
        self.project.follow_recording()
        self.opening.remember()

    def _keep_recording(self, recording: Recording) -> None:
        """Have trials track the subject that runs track."""
        unaided = dataclasses.replace(recording, reference=None, subject=self.project.subject())
        self.kept = KeptRecording(unaided, self.keypoints.mono_views(recording))

    def _on_edited(self, changed: Changed) -> None:
        if changed.tables & {SUBJECT.name, CHOICE.name}:
            self._on_subject()

    def _on_subject(self) -> None:
        recording, kept = self.document.recording, self.kept
        if recording is None or kept is None:
            return
        known = self.project.subject(), self.keypoints.mono_views(recording)
        if (kept.recording.subject, kept.mono) != known:
            self._keep_recording(recording)

    def _on_closed(self) -> None:
        self.project.close()
        self.track.stop(at_once=True)
        self.changes.tell(Part.LEAVING)
        self.judging.close()
        self.runs.clear()
        self.edits.clear()
        self.instant.clear()
        self.view_state.begin_anew()
        self.clouds.set_recording(None)
        self.kept = None
        if self.processes.trials.pid is not None:
            process = self.processes.trials
            Task("forgetting the clouds", lambda _: process(forget)).start()
        self.changes.tell(Part.RECORDING_CLOSED)

    def _on_project(self) -> None:
        self.edits.set_project(self.project.project)
        self._on_subject()

    def _on_settings(self) -> None:
        if self.clouds.parameters != self.track.settings.depth:
            self.clouds.parameters = self.track.settings.depth
            self.instant.tell_soon()
