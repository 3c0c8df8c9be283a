"""What is open and what is known about it, brought together."""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from stereotrack_core.annotation.predict import clicked_landmarks
from stereotrack_core.arrays import FloatArray
from stereotrack_core.errors import InputError
from stereotrack_core.experiments.run_process import load
from stereotrack_core.interop.run_file import holds_run, is_run_of, recording_of_run_file
from stereotrack_core.pose_model.installation import is_installed
from stereotrack_core.project.history import Changed
from stereotrack_core.project.scenarios import segments_of
from stereotrack_core.project.whereabouts import SUFFIX
from stereotrack_core.recording.description import Recording, Segment
from stereotrack_core.recording.folder import DESCRIPTION
from stereotrack_core.recording.importing.sources import is_media, is_unmade
from stereotrack_core.recording.selection import gives_depth
from stereotrack_core.study.description import SUFFIX as STUDY_SUFFIX
from stereotrack_core.tracking.detecting import detects_first
from stereotrack_core.tracking.frame import TrackedFrame
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.tuning.process import forget

from .base import Base
from .camera_doubts import CameraDoubts
from .changes import PROJECT, Part
from .failures import FailurePresenter
from .inspection import InspectionPresenter
from .instant import CloudPresenter, InstantPresenter
from .jobs import Job, NewestJob, Task
from .judgement import Judgement, JudgementPresenter, Truth, reference_at
from .keypoints import KeypointPresenter
from .messages import Message, stored_texts
from .project import ProjectPresenter
from .remedies import RemedyPresenter
from .runs import RunEntry, RunStyle
from .study import StudyPresenter
from .tracking import TrackPresenter
from .trials import TrialPresenter

_FEWEST_VIEWS = 2  # mono views with keypoints that can be tracked without depth
_RECENT = "recent"  # key of the paths that were opened last
MOST_RECENT = 10
_DETECTOR_HELPS = "The pose detector finds them, too: choose Track, Install pose detector …"


def unless(there: object, words: str) -> str:
    """Why something cannot be done, unless what it needs is there."""
    return "" if there else words


def _is_project(path: Path) -> bool:
    return path.suffix == SUFFIX and os.path.isfile(path)


def opens(path: Path) -> bool:
    """Whether a path is a folder, project, run, study, video or image, which can be opened."""
    named = path.name == DESCRIPTION or path.name.endswith(STUDY_SUFFIX)
    known = path.is_dir() or named or _is_project(path) or is_media(path)
    return known or (path.is_file() and holds_run(path))


@dataclass(frozen=True)
class Asked:
    """Project, frame, workspace and run that were asked for with the opening."""

    project: Path | None = None
    frame: int = 0
    workspace: str = ""  # its name; empty for the one that was shown last
    run: Path | None = None
    tracks: bool = False


@dataclass(frozen=True, eq=False)
class Snapshot:
    """State of the workbench at one moment, from which alone a panel shows."""

    recording: Recording | None = None
    frame: int = 0
    frame_count: int = 0
    runs: tuple[RunEntry, ...] = ()
    active: RunEntry | None = None
    front: RunEntry | None = None  # the trial that is chosen
    in_progress: RunEntry | None = None
    styles: Mapping[RunEntry, RunStyle] = field(default_factory=dict)
    judgements: Mapping[RunEntry, Judgement] = field(default_factory=dict)
    truth: Truth | None = None  # what errors are measured against
    settings: Settings = field(default_factory=Settings)  # of the next run
    selection: range | None = None

    @property
    def judgement(self) -> Judgement | None:
        """Judgement of the active run."""
        return None if self.active is None else self.judgements.get(self.active)

    @property
    def tracked(self) -> TrackedFrame | None:
        """Frame of the active run that is shown, if it was tracked."""
        return None if self.active is None else self.active.at(self.frame)


class Session(Base):
    """The open recording with its project, its runs and what follows from them."""

    def __post_init__(self) -> None:
        super().__post_init__()
        self._finding = NewestJob(self.tasks)
        self._ended = False
        self.said: Message | None = None  # once the recording is open
        self.asked = self._due = Asked()  # what was asked for when opening last
        self.document.on_opened, self.document.on_closed = self._on_opened, self._on_closed
        self.project = ProjectPresenter(self)
        self.keypoints = KeypointPresenter(self, self.project)
        self.clouds = CloudPresenter(self.changes.tell, self.tasks, lambda: self.track.settings)
        self.track = TrackPresenter(self, self.project, self.keypoints)
        self.judging = JudgementPresenter(self)
        self.cameras = CameraDoubts(self, self.project)  # whether one contradicts the others
        self.instant = InstantPresenter(self, self.keypoints, self.clouds, self.track)
        self._follow()
        self.trials = TrialPresenter(self, self.track, self.judging, self.instant, self.not_tried)
        self.inspection = InspectionPresenter(self, self.track, self.true_landmarks)
        self.failures = FailurePresenter(self, self.track, self.judging)
        self.study = StudyPresenter(self, self.track)
        self.remedies = RemedyPresenter(self, self.track, self.judging, self.failures, self.study)
        self.losses: list[Callable[[], str]] = [self._lost_runs, self.trials.lost_words]
        """Each says what would be lost by quitting now, empty for nothing."""
        self.ask_first: Callable[[str, Sequence[str], Callable[[], object]], object] = (
            lambda _what, _lost, do: do()
        )
        """Has the person agree to what something would lose, before the function does it."""
        self.tasks.watch(self.settled)

    def _follow(self) -> None:
        """Let the parts follow one another, in this order and before all features."""
        watch, hear = self.changes.watch, self.changes.hear
        # what undo does next is known before anybody asks for it, and so is the subject
        hear(Part.EDIT, self.edits.follow)
        hear(Part.EDIT, self._on_edit)
        watch(PROJECT, lambda: self.edits.set_project(self.project.project))
        watch(PROJECT, lambda: self.track.kept)  # a damaged subject is told at once
        # keypoints of another project come before what is drawn and tracked with them
        watch(PROJECT, self.keypoints.on_project)
        # runs are judged, and drawn, before panels ask how good they are
        watch(Part.RUN_FRAMES, self.judging.judge_soon)
        watch(Part.RUNS | Part.ACTIVE_RUN | Part.RUN_ENDED, self.judging.judge)
        hear(Part.EDIT, self.cameras.compare_soon)
        watch(Part.PROJECT_OPENED, self.cameras.compare_soon)
        watch(Part.PROJECT_CLOSING, self.cameras.forget)
        drawn = Part.KEYPOINTS | Part.CLOUD | Part.STEP | Part.DISPLAY | Part.RUNS | Part.ACTIVE_RUN
        watch(drawn | Part.SETTINGS, self.instant.tell_soon)
        watch(Part.IMAGES, self.instant.tell)
        hear(Part.TRACKED, self.instant.on_tracked)
        hear(Part.RESTED, self.instant.keep)
        watch(Part.TRACKING, self.instant.on_tracking)
        watch(Part.ACTIVE_RUN, lambda: self.keypoints.take_of(self.runs.active))

    def true_landmarks(self, frame: int) -> FloatArray | None:
        """Landmarks (9, 3) of a frame by the reference, else by clicks; None where neither is."""
        truth, project = self.judging.truth, self.project.project
        points = None if truth is None else reference_at(truth.trajectory, frame)
        recording = self.document.recording
        if points is None and project is not None and recording is not None:
            points = clicked_landmarks(recording.cameras, project.clicks.at(frame))
        return points

    @property
    def snapshot(self) -> Snapshot:
        document, runs = self.document, self.runs
        return Snapshot(
            document.recording,
            document.frame,
            document.frame_count,
            runs.entries,
            runs.active,
            runs.front,
            self.track.entry,
            {entry: runs.style(entry) for entry in runs.entries},
            self.judging.all(),
            self.judging.truth,
            self.track.settings,
            self.view_state.selection,
        )

    def settled(self) -> bool:
        parts = (
            *(self.document, self.judging, self.cameras, self.instant),
            *(self.trials, self.inspection, self.failures, self.remedies),
        )
        return not self.track.running and all(part.settled() for part in parts)

    def would_be_lost(self) -> tuple[str, ...]:
        """Sentences on work that quitting would lose; empty where nothing would be lost."""
        return tuple(words for lost in self.losses if (words := lost()))

    def leave(self, what: str, do: Callable[[], object]) -> None:
        """Do what closes the recording; where that loses something, if the person agrees."""
        self.ask_first(what, tuple(filter(None, (self._lost_runs(), self.trials.lost_words()))), do)

    def _lost_runs(self) -> str:
        runs = (e for e in self.runs.entries if e.kind == "run" and e.frames and not e.kept)
        names = [entry.name for entry in runs if entry.path is None]
        kept_soon = not self.project.why_no_edit()
        return "" if kept_soon or not names else f"runs without a project: {', '.join(names)}"

    def close(self) -> None:
        """End all work and close what is open, with the window."""
        self._ended = True
        self.document.pause()
        self.track.stop(at_once=True)
        self.changes.tell(Part.LEAVING)
        if self.given is None:
            self.processes.close()
        self.tasks.shutdown()
        self.document.close()
        self.changes.tell(Part.WINDOW_CLOSING)
        self.project.give_up()

    # ---- opening

    def recents(self) -> list[Path]:
        """Recordings and projects opened last that are still there, the newest first."""
        known = [Path(path) for path in stored_texts(self.settings, _RECENT) or ()]
        return [path for path in known if os.path.isdir(path) or _is_project(path)]

    def recent_folder(self) -> Path:
        """Folder of what was opened last, where dialogs start."""
        recent = self.recents()
        return recent[0].parent if recent else Path.home()

    def forget_recents(self) -> None:
        self.settings.setValue(_RECENT, [])
        self.changes.tell(Part.RECENT)

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
        self._finding.give_up()
        self.said = None
        if path.name.endswith(STUDY_SUFFIX) and path.is_file():
            self.changes.tell(Part.STUDY_WANTED, path)
            return
        if path.is_file() and holds_run(path):
            self._open_run(path, frame, workspace)
            return
        if is_unmade(path):
            self.changes.tell(Part.IMPORT_WANTED, (path,))
            return
        named = path.is_file() and path.name != DESCRIPTION
        project = path.resolve() if named else None

        def go_on() -> None:
            self.asked = self._due = Asked(project, frame, workspace or "", run, tracks)
            self.track.stop()
            if named:
                self.project.open_file(path, frame)
                return
            self.project.give_up()
            self.document.open(path.parent if path.name == DESCRIPTION else path, frame)

        self.leave("Open", go_on)

    def open_all(self, paths: Sequence[Path]) -> None:
        """Open what was dropped: several videos or folders of them together make a recording."""
        media = tuple(path for path in paths if is_unmade(path))
        others = [path for path in paths if path not in media]
        if others:
            self.open(others[0])
        elif media:
            self.changes.tell(Part.IMPORT_WANTED, media)

    def due(self) -> Asked:
        """What was asked for and is still to be done, once."""
        due, self._due = self._due, Asked()
        return due

    def _open_run(self, path: Path, frame: int, workspace: str | None) -> None:
        """Look for the recording of a run, off the window's thread, and open it with the run."""
        shown = self.document.recording

        def find(_task: Task) -> Path | None:
            of_shown = shown is not None and is_run_of(path, shown)
            return shown.folder if shown and of_shown else recording_of_run_file(path)

        def take(folder: Path | None) -> None:
            now = self.document.recording
            if now is not None and (folder is None or now.folder.resolve() == folder.resolve()):
                # what does not belong to it is said there
                self.changes.tell(Part.RUN_WANTED, path)
            elif folder is None:
                self.changes.tell(Part.RUN_ALONE, path)
            else:
                self.open(folder, frame=frame, workspace=workspace, run=path)

        title = f"looking for the recording of {path.name}"
        self._finding.run(Job(title, find, take))

    def _remember(self) -> None:
        """Put the recording that is open, or its project, first in the list of what was opened."""
        recording = self.document.recording
        if recording is None:
            return
        opened = self.asked.project or recording.folder.resolve()
        others = [path for path in self.recents() if path != opened]
        self.settings.setValue(_RECENT, [str(path) for path in (opened, *others)][:MOST_RECENT])
        self.changes.tell(Part.RECENT)

    def segments(self) -> tuple[Segment, ...]:
        """Named stretches of the recording and of the project."""
        recording = self.document.recording
        return () if recording is None else segments_of(self.project.project, recording)

    def _on_edit(self, changed: Changed) -> None:
        if "scenario" in changed.tables:
            self.changes.tell(Part.SCENARIOS)

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

    @property
    def finished_run(self) -> RunEntry | None:
        """The active run, unless it is still tracked or has no frames."""
        active = self.runs.active
        there = active is not None and active.frames and active is not self.track.entry
        return active if there else None

    # ---- following

    def _on_opened(self) -> None:
        refused, recording = None, self.document.recording
        if recording is not None:
            self.view_state.show_views(recording.views)
        try:
            self.clouds.set_recording(None if recording and recording.guessed else recording)
        except InputError as error:
            self.clouds.set_recording(None)
            refused = error
        self.changes.tell(Part.RECORDING_OPENED)
        self.changes.tell(Part.READY)
        if self.said is not None:
            self.tell(self.said)
            self.said = None
        if self.clouds.available:
            self._warm("starting the process that tracks", partial(self.processes.run, load))
        if refused is not None:
            self.tasks.failed(refused)
        self.project.follow_recording()
        self._remember()

    def _warm(self, title: str, work: Callable[[], object]) -> None:
        """Have a process be ready for what comes; where it cannot, that is told then."""
        job = Job(title, lambda _task: work(), failed=lambda _error: None)
        self.tasks.run(job, quiet=True)

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
        if self.processes.trials.pid is not None:
            self._warm("forgetting the clouds", partial(self.processes.trials, forget))
        self.changes.tell(Part.RECORDING_CLOSED)
