"""What is open and what is known about it, brought together."""

from __future__ import annotations

import dataclasses

from PySide6.QtCore import QObject, QSettings, Signal, Slot

from stereotrack_core.errors import InputError
from stereotrack_core.experiments.run_process import load
from stereotrack_core.pose_model.detect import DETECTOR_NAME
from stereotrack_core.pose_model.installation import is_installed
from stereotrack_core.project.history import Changed
from stereotrack_core.project.schema import CHOICE, SUBJECT
from stereotrack_core.recording.description import Recording, Subject
from stereotrack_core.recording.selection import gives_depth
from stereotrack_core.tracking.detecting import detects_first
from stereotrack_core.tracking.tuning.process import KeptRecording, forget

from ..services.failures import Tell, message_of
from ..services.tasks.task import Processes, Task, TaskList
from ..widgets.forms.message import Message
from .camera_doubts import CameraDoubts
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

_FEWEST_VIEWS = 2
"""Mono views with keypoints that can be tracked without depth."""

_DETECTOR_HELPS = "The pose detector finds them, too: choose Track, Install pose detector …"


class Session(QObject):
    """The open recording with its project, its runs and what follows from them."""

    leaving = Signal()
    """The recording is about to change or to be closed: what works on it stops."""
    opened = Signal()
    """Another recording is open; nothing is left of the one before."""
    ready = Signal()
    """All that shows the recording follows it."""
    closed = Signal()
    """There is no recording any more."""
    changed = Signal()
    """Something that can be seen of all this is another."""
    closing = Signal()
    """The window closes: whoever has a thread ends it."""

    def __init__(
        self,
        tell: Tell,
        tasks: TaskList,
        view_state: ViewState,
        settings: QSettings,
        parent: QObject,
        processes: Processes | None = None,
    ) -> None:
        super().__init__(parent)
        self._tell, self._tasks, self._view_state = tell, tasks, view_state
        self.runs = RunList(self)
        self.document = DocumentPresenter(tasks, tell, self)
        """Recording, frame and playback."""
        self.document.opened.connect(self._on_opened)  # before that of its project
        self.project = ProjectPresenter(self.document, tasks, settings, tell, self)
        self.edits = EditStack(tell, self)
        """Everything that a person did, to be undone and redone in one order."""
        self._lead_edits()
        self.keypoints = KeypointPresenter(self.project, self.edits, tasks, self)
        """What 2-D detectors have predicted."""
        self.clouds = CloudPresenter(tell, self)
        self.processes = processes or Processes()
        """Where work is done that lasts."""
        self._own_processes = processes is None
        self.kept: KeptRecording | None = None
        """What is open, for tasks that use the clouds of one another."""
        self.track = TrackPresenter(
            self.runs, self.keypoints, self.subject, self.processes.run, tell, self
        )
        """The tracker at work."""
        self.opening = Opening(self.document, self.project, self.track, tasks, settings, self)
        """Opens recordings, projects and runs."""
        self.judging = JudgementPresenter(self.document, self.runs, tell, self)
        """How good the runs are."""
        self.cameras = CameraDoubts(self.document, self.project, tell, self)
        """Whether a camera contradicts the others."""
        self.instant = InstantPresenter(
            self.document, self.clouds, self.runs, self.track, self.keypoints, view_state, self
        )
        """Everything known about the frame that is shown."""
        self.tracker = TrackControl(
            self.document, self.runs, self.track, view_state, self.edits, self
        )
        """What its commands mean in the state that the session is in."""
        self.clouds.parameters = self.track.settings.depth
        self.keypoints.changed.connect(self._on_subject)
        self._connect()
        tasks.watch(self.settled)

    def _connect(self) -> None:
        self.document.closed.connect(self._on_closed)
        self.track.settings_changed.connect(self._on_settings)
        self.track.finished.connect(self.judging.judge)
        self.runs.active_changed.connect(self._take_detected)
        self._watch_changes()

    def _lead_edits(self) -> None:
        """Tell the edits of the project before whoever asks what is known of them."""
        self.project.changed.connect(self.edits.follow)
        self.project.changed.connect(self._on_edited)
        self.project.opened.connect(self._on_project)
        self.project.closed.connect(self._on_project)

    def _watch_changes(self) -> None:
        """Tell whatever changes of all this."""
        document, project, runs = self.document, self.project, self.runs
        for changed in (
            document.frame_changed, document.playing_changed, document.count_changed,
            document.findings_changed, self.track.state_changed, runs.changed, runs.grew,
            runs.active_changed, project.opened, project.closed, project.changed,
            self.edits.changed, self.keypoints.changed,
        ):  # fmt: skip
            changed.connect(self._tell_change)

    def subject(self) -> Subject | None:
        """Whose body is tracked: the project's subject, else the recording's."""
        project, recording = self.project.project, self.document.recording
        own = None if project is None else project.subject()
        return own if own is not None or recording is None else recording.subject

    def settled(self) -> bool:
        """Whether everything that was asked for is there."""
        parts = (self.document, self.judging, self.cameras, self.instant)
        return not self.track.running and all(part.settled() for part in parts)

    def close(self) -> None:
        """End all work and close what is open, with the window."""
        self.opening.end()
        self.document.pause()
        self.track.stop(at_once=True)
        self.leaving.emit()
        if self._own_processes:
            self.processes.close()
        self._tasks.shutdown()
        self.document.close()
        self.closing.emit()
        self.cameras.close()
        self.judging.close()
        self.project.close()
        self.project.give_up()
        self.clouds.set_recording(None)

    # ---- why something cannot be done now, in sentences

    def no_recording(self) -> str:
        """Nothing is open."""
        if self.document.opening:
            return "The recording is still loading."
        return (
            "" if self.document.recording is not None else "No recording is open. Open one first."
        )

    def no_project(self) -> str:
        """No project is open, be it for reading."""
        there = self.project.project is not None
        return self.no_recording() or ("" if there else self.project.why_no_edit())

    def no_edit(self) -> str:
        """Nothing can be changed in the project."""
        return self.no_recording() or self.project.why_no_edit()

    def no_frames(self) -> str:
        """There is no frame to go to."""
        none = (
            ""
            if self.document.frame_count
            else "The recording has no frames. See Recording checks."
        )
        return self.no_recording() or none

    def no_depth(self) -> str:
        """No view gives depth."""
        recording = self.document.recording
        if recording is not None and recording.guessed:
            return "The calibration is a guess. Replace it with a calibration of these cameras."
        none = "This needs depth, which no view of this recording provides."
        return self.no_frames() or ("" if self.clouds.available else none)

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
        return none if known is None else ""

    def no_run(self) -> str:
        """There is no run."""
        active = self.runs.active
        there = active is not None and bool(active.frames)
        return self.no_recording() or (
            "" if there else "There is no run yet. Run the tracker or open a run."
        )

    def tracker_works(self) -> str:
        """The tracker is running."""
        return "The tracker is running. Pause it first." if self.track.running else ""

    # ---- following

    @Slot()
    def _take_detected(self) -> None:
        """Keypoints that the active run detected in mono views come back with it."""
        entry, recording = self.runs.active, self.document.recording
        run = None if entry is None else entry.stored
        if entry is None or run is None or run.keypoints is None or recording is None:
            return
        if (run.meta.get("keypoints") or {}).get("sources") == [DETECTOR_NAME]:
            self.keypoints.remember(entry.wanted, run.keypoints)

    @Slot()
    def _tell_change(self, _what: object = None) -> None:
        self.changed.emit()

    @Slot()
    def _on_opened(self) -> None:
        refused, recording = None, self.document.recording
        if recording is not None:  # the tracker never sees the truth
            self._keep_recording(recording)
            self._view_state.show_views(recording.views)
        try:
            measured = recording is not None and not recording.guessed
            self.clouds.set_recording(recording if measured else None)
        except InputError as error:
            self.clouds.set_recording(None)
            refused = error
        self.opened.emit()
        self.ready.emit()
        if self.clouds.available:
            Task("starting the process that tracks", lambda _: self.processes.run(load)).start()
        if refused is not None:
            self._tell(message_of(refused))
        if recording is not None and recording.guessed:
            self._tell(_guessed(recording.name))

    def _keep_recording(self, recording: Recording) -> None:
        """Have trials track the subject that runs track."""
        unaided = dataclasses.replace(recording, reference=None, subject=self.subject())
        self.kept = KeptRecording(unaided, self.keypoints.mono_views(recording))

    @Slot(object)
    def _on_edited(self, changed: Changed) -> None:
        if changed.tables & {SUBJECT.name, CHOICE.name}:
            self._on_subject()

    @Slot()
    def _on_subject(self) -> None:
        recording, kept = self.document.recording, self.kept
        if recording is None or kept is None:
            return
        known = self.subject(), self.keypoints.mono_views(recording)
        if (kept.recording.subject, kept.mono) != known:
            self._keep_recording(recording)

    @Slot()
    def _on_closed(self) -> None:
        self.track.stop(at_once=True)
        self.leaving.emit()
        self.judging.close()
        self.runs.clear()
        self.edits.clear()
        self.instant.clear()
        self._view_state.begin_anew()
        self.clouds.set_recording(None)
        self.kept = None
        if self.processes.trials.pid is not None:
            Task("forgetting the clouds", lambda _: self.processes.trials(forget)).start()
        self.closed.emit()

    @Slot()
    def _on_project(self) -> None:
        self.edits.set_project(self.project.project)
        self._on_subject()

    @Slot()
    def _on_settings(self) -> None:
        if self.clouds.parameters != self.track.settings.depth:
            self.clouds.parameters = self.track.settings.depth
            self.instant.tell_soon()


def _guessed(recording: str) -> Message:
    return Message(
        "note",
        "the cameras of this recording are guessed from the size of the images",
        recording,
        "Landmarks can be clicked. 3-D positions, fitting and tracking need a calibration.",
    )
