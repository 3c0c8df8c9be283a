"""The tracker at work: run, pause, step, one iteration, from here, a selection."""

from __future__ import annotations

import dataclasses
import threading
import time
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import QObject, QTimer, Signal, Slot

from stereotrack_core.body.model import BodyModel, body_model
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.errors import Cancelled
from stereotrack_core.interop.run_journal import RunJournal
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.tracking.frame import Origin, TrackedFrame
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run import Pipeline
from stereotrack_core.tracking.run_checks import CHECK, Untracked, misfits
from stereotrack_core.tracking.run_spec import FirstPose, RunSpec

from ..services.failures import message_of
from ..services.tasks.shared import Shared
from ..services.tasks.task import WorkThread
from ..widgets.forms.message import Message
from .runs import RunEntry, RunList

UPDATES_PER_SECOND = 20


@dataclass(frozen=True, eq=False)
class Order:
    """What the tracker shall do; every frame goes to the journal at once, where there is one."""

    recording: Recording
    settings: Settings
    preset: str
    frames: range
    init: FirstPose
    reader: Shared[FrameReader] | None
    journal: Path | None = None


class TrackWorker:
    """Tracks in a thread of its own and may be held after every frame.

    Results wait in a list until :meth:`taken` fetches them, so that a window that is busy
    slows nothing down and loses nothing.
    """

    def __init__(self, order: Order) -> None:
        self.order = order
        self.origin: Origin | None = None
        self.body: BodyModel | None = None
        self.pipeline: Pipeline | None = None
        self.error: Exception | None = None
        self.done = False
        self.worked_seconds = 0.0
        self._allowed = 0.0
        self._stop = False
        self._working = False
        self._results: list[TrackedFrame] = []
        self._condition = threading.Condition()
        self._thread = WorkThread(self._run, "track")
        self._thread.start()

    def allow(self, frames: float) -> None:
        """Let the tracker go on for so many frames; infinity lets it run."""
        with self._condition:
            self._allowed = frames
            self._condition.notify_all()

    def hold(self) -> None:
        """Stop after the frame in work."""
        self.allow(0.0)

    @property
    def running(self) -> bool:
        """Whether a frame is in work or not fetched yet, or the tracker has leave to go on."""
        return not self.done and (self._allowed > 0 or self._working or bool(self._results))

    def stop(self, seconds: float = 15.0) -> None:
        """End the thread; what was tracked stays."""
        with self._condition:
            self._stop = True
            self._condition.notify_all()
        self._thread.join(seconds)

    def taken(self) -> list[TrackedFrame]:
        """Results since the last call."""
        with self._condition:
            results, self._results = self._results, []
        return results

    def _wait(self) -> bool:
        with self._condition:
            self._condition.wait_for(lambda: self._stop or self._allowed > 0)
            self._working = not self._stop
            return self._working

    def _run(self) -> None:
        order = self.order
        begun = time.perf_counter()
        keeper: RunJournal | None = None
        try:
            if order.journal is not None:
                keeper = RunJournal(order.journal, lambda: self.worked_seconds)
            with (
                order.reader.used() if order.reader is not None else nullcontext() as reader,
                Pipeline(
                    order.recording,
                    RunSpec(order.settings, init=order.init, preset=order.preset),
                    reader=reader,
                    keeper=keeper,
                ) as pipeline,
            ):
                pipeline.on_first_pass = self._go_on_preparing
                pipeline.prepare(order.frames)
                self.worked_seconds = time.perf_counter() - begun
                self.body, self.origin = pipeline.body, pipeline.origin()
                self.pipeline = pipeline
                self._follow(pipeline)
        except Cancelled:
            pass  # stopped before the first frame
        except Exception as error:  # noqa: BLE001 - handed to the window, which shows it
            self.error = error
        finally:
            if keeper is not None:
                keeper.close()
            self.done = True

    def _go_on_preparing(self, _: TrackedFrame) -> None:
        if self._stop:
            raise Cancelled

    def _follow(self, pipeline: Pipeline) -> None:
        frames = pipeline.frames(self.order.frames)
        try:
            while self._wait():
                begun = time.perf_counter()
                tracked = next(frames, None)
                if tracked is None:
                    return
                with self._condition:
                    self.worked_seconds += time.perf_counter() - begun
                    self._results.append(tracked)
                    self._allowed -= 1
                    self._working = False
        finally:
            close: Callable[[], None] = getattr(frames, "close", lambda: None)
            close()


class TrackPresenter(QObject):
    """Controls the tracker and collects what it finds, at most 20 times a second.

    Signals
    -------
    advanced : TrackedFrame
        The newest frame, still with its cloud and correspondences.
    state_changed : ()
        Running, paused, finished or idle.
    finished : RunEntry
        A run has come to its end.
    settings_changed : ()
        The next run or step is done with other settings, or another preset was chosen.
    message : Message
        Why tracking has ended early.
    """

    advanced = Signal(object)
    state_changed = Signal()
    finished = Signal(object)
    settings_changed = Signal()
    message = Signal(object)

    def __init__(self, runs: RunList, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._runs = runs
        self._worker: TrackWorker | None = None
        self._entry: RunEntry | None = None
        self.preset = "accurate"
        self.settings = self.base = preset(self.preset)
        self.place_for_run: Callable[[], Path | None] = lambda: None
        self._timer = QTimer(self, interval=1000 // UPDATES_PER_SECOND)
        self._timer.timeout.connect(self._collect)

    @property
    def entry(self) -> RunEntry | None:
        """The run in progress, running or paused."""
        return self._entry

    @property
    def running(self) -> bool:
        """Whether the tracker works at this moment."""
        return self._worker is not None and self._worker.running

    @property
    def paused(self) -> bool:
        """Whether a run waits to go on."""
        return self._worker is not None and not self._worker.running

    @property
    def differs_from_preset(self) -> bool:
        """Whether the settings are no longer those of the preset."""
        return self.settings != self.base

    def choose(self, name: str, settings: Settings) -> None:
        """Take all values from a preset, for the next run or step."""
        self.preset = name
        self.base = settings
        self.use(settings)

    def use(self, settings: Settings) -> None:
        """Use these settings for the next run or step."""
        self.settings = settings
        self.settings_changed.emit()

    @property
    def stale(self) -> bool:
        """Whether the run in progress was made with other settings."""
        return self._worker is not None and self._worker.order.settings != self.settings

    def next_frame(self) -> int | None:
        """The frame that the run in progress does next."""
        if self._entry is None:
            return None
        done = len(self._entry.frames)
        return self._entry.wanted[done] if done < len(self._entry.wanted) else None

    def begin(
        self,
        recording: Recording,
        frames: range,
        init: FirstPose,
        reader: Shared[FrameReader] | None,
        *,
        allowed: float = float("inf"),
    ) -> RunEntry:
        """Begin a new run; the one in progress ends and keeps what it has."""
        self.stop()
        changed = self.differs_from_preset
        body = body_model(proportions_of(recording.subject), self.settings.body)
        name = self._runs.next_name(self.preset, changed=changed)
        self._entry = RunEntry(name, self.preset, self.settings, body, frames)
        # the tracker never sees the truth
        unaided = dataclasses.replace(recording, reference=None)
        self._entry.journal = self.place_for_run()
        self._worker = TrackWorker(
            Order(unaided, self.settings, self.preset, frames, init, reader, self._entry.journal)
        )
        self._worker.allow(allowed)
        self._timer.start()
        self._runs.add(self._entry)
        self.state_changed.emit()
        return self._entry

    def go_on(self, allowed: float = float("inf")) -> None:
        """Go on with the run in progress."""
        if self._worker is not None:
            self._worker.allow(allowed)
            self._timer.start()
            self.state_changed.emit()

    def pause(self) -> None:
        """Hold after the frame in work."""
        if self._worker is not None:
            self._worker.hold()
            self.state_changed.emit()

    def stop(self) -> None:
        """End the run in progress; it keeps what it has."""
        worker, entry = self._worker, self._entry
        if worker is None:
            return
        worker.stop()
        self._collect()
        self._timer.stop()
        self._worker = self._entry = None
        if entry is not None:
            entry.warnings = misfits(entry.frames.values(), worker.order.settings)
            if not entry.frames:
                self._runs.remove(entry)
        self.state_changed.emit()

    def last_pose(self) -> Pose | None:
        """Newest pose of the run in progress."""
        if self._entry is None or not self._entry.frames:
            return None
        return self._entry.frames[max(self._entry.frames)].pose

    @property
    def started(self) -> bool:
        """Whether the run in progress has a frame already."""
        return self._entry is not None and bool(self._entry.frames)

    @property
    def preparing(self) -> bool:
        """Whether a run has been begun that cannot do its first frame yet."""
        return self._worker is not None and self._worker.pipeline is None

    def held_before(self, frame: int) -> Pipeline | None:
        """The run's pipeline, if it is held and does this frame next."""
        worker = self._worker
        if worker is None or worker.running or worker.done or self.next_frame() != frame:
            return None
        return worker.pipeline

    @Slot()
    def _collect(self) -> None:
        worker, entry = self._worker, self._entry
        if worker is None or entry is None:
            self._timer.stop()
            return
        ended = worker.done  # asked before the results are fetched, so that none is left behind
        results = worker.taken()
        entry.origin, entry.body = worker.origin, worker.body or entry.body
        entry.wall_seconds = worker.worked_seconds
        for tracked in results:
            entry.frames[tracked.frame] = tracked.without_cloud()
        if results:
            self._runs.grew.emit()
            self.advanced.emit(results[-1])
        if ended:
            self._finish(worker, entry)
        elif not worker.running:
            self.state_changed.emit()

    def _finish(self, worker: TrackWorker, entry: RunEntry) -> None:
        self._timer.stop()
        self._worker = self._entry = None
        if worker.error is not None:
            self.message.emit(message_of(worker.error))
        if not entry.frames:
            self._runs.remove(entry)
        self.state_changed.emit()
        self._tell_signs(worker.order, entry)
        self.finished.emit(entry)

    def _tell_signs(self, order: Order, entry: RunEntry) -> None:
        """Say why nobody was tracked, where that is so, or that nothing fits."""
        frames = entry.frames.values()
        entry.warnings = misfits(frames, order.settings)
        if entry.warnings:
            what = "; ".join(entry.warnings)
            self.message.emit(Message("warning", what, entry.name, CHECK))
        if not frames or any(frame.tracked for frame in frames):
            return
        causes = Untracked(order.recording, order.settings).take(frames).causes()
        self.message.emit(
            Message(
                "warning",
                "no frame of the run has a tracked person",
                entry.name,
                " ".join(cause.sentence() for cause in causes),
            )
        )
