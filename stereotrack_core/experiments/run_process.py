"""A run that is tracked in a process of its own: what it is told, and what it tells."""

import dataclasses
import threading
import time
from contextlib import ExitStack, closing
from dataclasses import dataclass
from pathlib import Path

from stereotrack_core.body.model import BodyModel
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.interop.run_journal import RunJournal
from stereotrack_core.pose_model.detect import detect_keypoints
from stereotrack_core.pose_model.detector import required_detector
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader, reference_pictures
from stereotrack_core.tracking.clouds import Clouds
from stereotrack_core.tracking.detecting import detects_first
from stereotrack_core.tracking.frame import Origin, TrackedFrame
from stereotrack_core.tracking.prepare import prepare
from stereotrack_core.tracking.run import advances
from stereotrack_core.tracking.run_spec import Hooks, RunSpec
from stereotrack_core.tracking.tracking import Tracking
from stereotrack_core.worker_processes import Asker

_TELL_SECONDS = 0.2


@dataclass(frozen=True)
class Allow:
    """Go on for so many frames from now; infinity: to the end, 0: hold after the frame in work."""

    frames: float
    number: int  # said again when the tracker is held


@dataclass(frozen=True)
class Show:
    """Send the views' depth images with each frame from now on, or no longer."""

    depths: bool


@dataclass(frozen=True)
class Preparing:
    """How far what comes before the first frame is."""

    stage: str  # in words
    done: int
    count: int  # how much of the stage is done, and of how much


@dataclass(frozen=True, eq=False)
class Prepared:
    """The first frame can be done now."""

    body: BodyModel  # that is tracked
    origin: Origin


@dataclass(frozen=True, eq=False)
class Tracked:
    """A frame is done."""

    frame: TrackedFrame  # its cloud is without depth images unless they are to be shown
    seconds: float  # time that has been worked on the run so far, without pauses


@dataclass(frozen=True, eq=False)
class Held:
    """The tracker waits before a frame, or has done the last one."""

    number: int  # that of the newest :class:`Allow` that it knows
    cloud: Cloud | None  # of the last frame, with depth images; None if sent before


def load(_: Asker) -> None:
    """Do nothing: what tracking needs is loaded with this module."""


@dataclass(frozen=True, eq=False)
class RunTask:
    """Tracks the frames of a specification, which is picklable as all that it is made of."""

    recording: Recording
    spec: RunSpec  # with its frames
    journal: Path | None  # where every frame is kept at once
    allowed: Allow  # how far it may go at first

    def __call__(self, asker: Asker) -> None:
        """Do it, until the end or until it is no longer wanted."""
        _Work(self, asker).do()


class _Work:
    """A run under way."""

    def __init__(self, task: RunTask, asker: Asker) -> None:
        self._task, self._asker, self._allowed = task, asker, task.allowed
        self._left = task.allowed.frames
        self._unsent: Cloud | None = None
        self._depths = False
        self._begun = time.perf_counter()
        self._paused = self._told = 0.0
        self._stage, self._found = "", (False, "", 0)
        self._telling = threading.Lock()

    def do(self) -> None:
        """Track until the end, or until told to stop."""
        task = self._task
        self._listen(0.0)
        with ExitStack() as opened:
            journal = None
            if task.journal is not None:
                journal = opened.enter_context(closing(RunJournal(task.journal, self._seconds)))
            spec = self._with_keypoints(task.spec)
            clouds = opened.enter_context(Clouds(task.recording, spec))
            run = prepare(clouds, Hooks(self._prepare))
            self._tell_prepared(run)
            newest = -1
            for advance in advances(run, clouds.frames, Hooks(self._prepare, self._hold)):
                if journal is not None:
                    journal.keep(advance)
                if advance.run.found_so_far != self._found:
                    self._tell_prepared(advance.run)
                for tracked in advance.gained.frames:
                    if tracked.frame > newest:  # those that come again were allowed before
                        self._left, newest = self._left - 1, tracked.frame
                    self._tell_frame(tracked)
            self._tell_held()

    def _with_keypoints(self, spec: RunSpec) -> RunSpec:
        """The specification with keypoints that are detected first, if mono views need them."""
        recording = self._task.recording
        if spec.keypoints is not None or not detects_first(recording, spec.settings):
            return spec
        frames = spec.frames_of(0)

        def note(done: int) -> None:
            self._prepare("detecting keypoints", done, len(frames))

        note(0)
        with FrameReader(reference_pictures(recording)) as reader:
            found = detect_keypoints(reader, required_detector(), frames, on_frame=note)
        return dataclasses.replace(spec, keypoints=found)

    def _tell_prepared(self, run: Tracking) -> None:
        """Tell the body and the origin of a run: again where they change."""
        self._found = run.found_so_far
        self._asker.tell(Prepared(run.body, run.origin()))

    def _seconds(self) -> float:
        return time.perf_counter() - self._begun - self._paused

    def _prepare(self, stage: str, done: int, count: int) -> None:
        """May be called from several threads at once."""
        with self._telling:
            self._listen(0.0)
            if stage != self._stage or time.monotonic() - self._told > _TELL_SECONDS:
                self._stage, self._told = stage, time.monotonic()
                self._asker.tell(Preparing(stage, done, count))

    def _hold(self) -> None:
        """Wait before a step until it is allowed."""
        begun = time.perf_counter()
        self._listen(0.0)
        while self._left <= 0:
            self._tell_held()
            self._listen(None)
        self._paused += time.perf_counter() - begun

    def _listen(self, seconds: float | None) -> None:
        for order in self._asker.orders(seconds):
            match order:
                case Allow():
                    self._allowed, self._left = order, order.frames
                case Show():
                    self._depths = order.depths

    def _tell_frame(self, tracked: TrackedFrame) -> None:
        """Send a frame; its depth images are ten times as much as all else together."""
        self._unsent = None if self._depths else tracked.cloud
        if self._unsent is not None:
            points = dataclasses.replace(tracked.cloud, depths={})
            tracked = dataclasses.replace(tracked, cloud=points)
        self._asker.tell(Tracked(tracked, self._seconds()))

    def _tell_held(self) -> None:
        self._asker.tell(Held(self._allowed.number, self._unsent))
        self._unsent = None
