"""The tracker at work: run, pause, step, one iteration, from here, a selection."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from PySide6.QtCore import QElapsedTimer, QObject, Signal, Slot

from stereotrack_core.body.model import body_of_subject
from stereotrack_core.body.pose import Pose
from stereotrack_core.errors import Cancelled
from stereotrack_core.experiments.run_process import (
    Allow,
    Held,
    Prepared,
    Preparing,
    RunTask,
    Show,
    Tracked,
)
from stereotrack_core.recording.description import Recording, Subject
from stereotrack_core.tracking.detecting import detects_first
from stereotrack_core.tracking.frame import TrackedFrame
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run_checks import CHECK, Untracked, run_warnings
from stereotrack_core.tracking.run_spec import FirstPose, RunSpec
from stereotrack_core.tracking.tuning.stages import changes_in_words
from stereotrack_core.worker_processes import Lost, TaskProcess

from ..services.failures import Tell, message_of
from ..services.tasks.task import Task, how_far, time_left
from ..widgets.forms.message import Message
from ..widgets.redraw import later
from .keypoints import KeypointPresenter
from .runs import RunEntry, RunList

UPDATE_MS = 50


@dataclass(frozen=True)
class Chosen:
    """What is tracked with: a preset, its values, and the values as they are."""

    preset: str
    base: Settings
    settings: Settings


class LiveRun:
    """A run that a process tracks, as far as the window knows."""

    def __init__(self, entry: RunEntry, run: RunTask, process: TaskProcess) -> None:
        self.entry, self.recording, self.settings = entry, run.recording, run.spec.settings
        self._spec = run.spec
        self.detects = run.spec.keypoints is None and detects_first(run.recording, self.settings)
        """Whether it detects keypoints in mono views before its first frame."""
        self.held = False
        """Whether it waits for leave to go on, with every frame fetched."""
        self.progress: Preparing | None = None
        """How far it is with what comes before its first frame."""
        self.waiting: list[TrackedFrame] = []
        self.task = Task("track", lambda task: process(run, task.tell, task.token.cancelled))
        self.order = partial(process.order, run)
        self._number = run.allowed.number
        self._stage_begun = 0.0
        self._first_seconds: float | None = None

    def allow(self, frames: float) -> None:
        """Let it go on for so many frames; infinity lets it run, 0 holds it."""
        self._number += 1
        self.held = self.held and not frames
        self.order(Allow(frames, self._number))

    def hear(self, word: Any) -> None:
        """Remember what the process tells."""
        match word:
            case Preparing():
                if self.progress is None or word.stage != self.progress.stage:
                    self._stage_begun = time.monotonic()
                self.progress = word
            case Prepared():
                self.entry.body, self.entry.origin = word.body, word.origin
            case Tracked():
                self.waiting.append(word.frame)
                self.entry.wall_seconds, self.progress = word.seconds, None
                if self._first_seconds is None:
                    self._first_seconds = word.seconds
            case Held():
                self.held = word.number == self._number

    def taken(self) -> list[TrackedFrame]:
        """Let the entry have the frames that have come since the last time."""
        frames, self.waiting = self.waiting, []
        for frame in frames:
            self.entry.put(frame.without_cloud())
        return frames

    def end(self) -> None:
        """Nothing more comes of it."""
        frames = list(self.entry.ordered())
        self.entry.warnings = run_warnings(frames, self.entry.body, self.recording, self._spec)

    def preparing_words(self) -> str:
        """``learning the background, 40 %, about 3 s left``."""
        progress = self.progress
        if progress is None:
            return "" if self.entry.frames else "starting"
        share = progress.done / max(progress.count, 1)
        far = how_far(share, time.monotonic() - self._stage_begun)
        return f"{progress.stage}, {far}" if far else progress.stage

    def left_words(self) -> str:
        """``about 40 s left``; empty where nobody knows it yet."""
        done, first = len(self.entry.frames) - 1, self._first_seconds
        if done < 1 or first is None:
            return ""
        each = (self.entry.wall_seconds - first) / done
        return time_left(each * (len(self.entry.wanted) - done - 1))


class TrackPresenter(QObject):
    """Controls the tracker and collects what it finds, at most 20 times a second."""

    advanced = Signal(object)
    """The newest frame, still with its cloud and correspondences."""
    rested = Signal(object)
    """The cloud of the frame at which the tracker has stopped, with its depth images."""
    state_changed = Signal()
    """Running, paused, finished or idle, or further in preparing."""
    finished = Signal(object)
    """A run has come to its end."""
    settings_changed = Signal()
    """The next run or step is done with other settings, or another preset was chosen."""

    def __init__(
        self,
        runs: RunList,
        keypoints: KeypointPresenter,
        subject: Callable[[], Subject | None],
        process: TaskProcess,
        tell: Tell,
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self._runs, self._keypoints, self._process = runs, keypoints, process
        self._subject, self.tell = subject, tell
        self._live: LiveRun | None = None
        self._ending: list[LiveRun] = []
        self._depths = False
        self.preset = "accurate"
        self.settings = self.base = preset(self.preset)
        self.place_for_run: Callable[[], Path | None] = lambda: None
        self._since = QElapsedTimer()
        self._since.start()
        self._timer = later(self, self._collect)

    @property
    def entry(self) -> RunEntry | None:
        """The run in progress, running or paused."""
        return self._live.entry if self._live is not None else None

    @property
    def running(self) -> bool:
        """Whether the tracker works at this moment, or has frames that are not fetched yet."""
        return self._live is not None and not self._live.held

    @property
    def paused(self) -> bool:
        """Whether a run waits to go on."""
        return self._live is not None and self._live.held

    def holds(self, entry: RunEntry) -> bool:
        """Whether a run is in progress, or has been stopped and may still get a frame."""
        return any(live.entry is entry for live in (self._live, *self._ending) if live is not None)

    @property
    def chosen(self) -> Chosen:
        """What the next run or step is tracked with."""
        return Chosen(self.preset, self.base, self.settings)

    def name_of(self, settings: Settings) -> str:
        """What a run with these settings is called: ``fast, iterations 3``."""
        changes = changes_in_words(self.base, settings)
        return f"{self.preset}, {changes}" if changes else self.preset

    def choose(self, name: str, settings: Settings) -> None:
        """Take all values from a preset, for the next run or step."""
        self.take(Chosen(name, settings, settings))

    def take(self, chosen: Chosen) -> None:
        """Use these settings of a preset for the next run or step."""
        self.preset, self.base, self.settings = chosen.preset, chosen.base, chosen.settings
        self.settings_changed.emit()

    @property
    def stale(self) -> bool:
        """Whether the run in progress was made with other settings."""
        return self._live is not None and self._live.settings != self.settings

    def next_frame(self) -> int | None:
        """The frame that the run in progress does next."""
        entry = self.entry
        if entry is None:
            return None
        done = len(entry.frames)
        return entry.wanted[done] if done < len(entry.wanted) else None

    def begin(
        self,
        recording: Recording,
        frames: range,
        init: FirstPose,
        *,
        allowed: float = float("inf"),
    ) -> RunEntry:
        """Begin a new run; the one in progress ends and keeps what it has."""
        self.stop()
        subject = self._subject() or recording.subject
        body = body_of_subject(subject, self.settings.body)
        name = self._runs.next_name(self.name_of(self.settings))
        entry = RunEntry(name, self.preset, self.settings, body, frames)
        entry.journal = self.place_for_run()
        seen = self._keypoints.for_run(self.settings, frames)
        spec = RunSpec(self.settings, self.preset, frames=frames, init=init, keypoints=seen)
        # the tracker never sees the truth
        unaided = dataclasses.replace(recording, reference=None, subject=subject)
        task = RunTask(unaided, spec, entry.journal, Allow(allowed, 0))
        live = self._live = LiveRun(entry, task, self._process)
        live.task.told.connect(partial(self._on_told, live))
        live.task.ended.connect(partial(self._on_ended, live))
        live.order(Show(self._depths))
        live.task.start()
        self._runs.add(entry)
        self.state_changed.emit()
        return entry

    def go_on(self, allowed: float = float("inf")) -> None:
        """Go on with the run in progress; 0: hold after the frame in work."""
        if self._live is not None:
            self._live.allow(allowed)
            self.state_changed.emit()

    def pause(self) -> None:
        """Hold after the frame in work."""
        self.go_on(0.0)

    def stop(self, *, at_once: bool = False) -> None:
        """End the run in progress; it keeps what it has, and gets the frame in work.

        Parameters
        ----------
        at_once : bool
            Whether the frame in work is given up and the run's journal let go before this
            returns, also of runs that were stopped before.
        """
        live = self._live
        if live is not None:
            live.task.cancel()
            self._ending.append(live)
        if at_once and self._ending:
            for ended in self._ending:
                ended.task.give_up()
            self._process.end()
        self._collect()
        self._live = None
        if live is not None and not live.entry.frames:
            self._runs.remove(live.entry)
        if at_once:
            for ended in self._ending:
                ended.end()
            self._ending.clear()
        if live is not None:
            self.state_changed.emit()

    def show_depths(self, *, shown: bool) -> None:
        """Have every frame come with its views' depth images, or without."""
        if shown != self._depths:
            self._depths = shown
            if self._live is not None:
                self._live.order(Show(shown))

    def last_pose(self) -> Pose | None:
        """Newest pose of the run in progress."""
        entry = self.entry
        return entry.frames[max(entry.frames)].pose if entry is not None and entry.frames else None

    def preparing_words(self) -> str:
        """What the run in progress does before its first frame, and how far it is."""
        return self._live.preparing_words() if self._live is not None else ""

    def left_words(self) -> str:
        """How long the run in progress takes until its last frame, about."""
        return self._live.left_words() if self._live is not None else ""

    @property
    def preparing_share(self) -> float:
        """How much of a stage before the first frame is done, 0 to 1."""
        progress = self._live.progress if self._live is not None else None
        return progress.done / max(progress.count, 1) if progress is not None else 0.0

    def _on_told(self, live: LiveRun, words: list[Any]) -> None:
        for word in words:
            live.hear(word)
            self._follow(live, word)

    def _follow(self, live: LiveRun, word: Any) -> None:
        match word:
            case Tracked():
                if not self._timer.isActive():
                    self._timer.start(max(0, UPDATE_MS - self._since.elapsed()))
            case Held():
                self._collect()
                if word.cloud is not None and live is self._live:
                    self.rested.emit(word.cloud)
                self.state_changed.emit()
            case Preparing() | Prepared() if live is self._live:
                self.state_changed.emit()
                seen = word.origin.spec.keypoints if isinstance(word, Prepared) else None
                if live.detects and seen is not None:
                    self._keypoints.remember(live.entry.wanted, seen)

    @Slot()
    def _collect(self) -> None:
        """Take what has come, and show the newest frame of the run in progress."""
        self._timer.stop()
        self._since.start()
        for ended in self._ending:
            ended.taken()
        frames = self._live.taken() if self._live is not None else []
        if frames:
            self._runs.grew.emit()
            self.advanced.emit(frames[-1])

    def _on_ended(self, live: LiveRun) -> None:
        error = live.task.error
        self._collect()
        live.end()
        if live is not self._live:
            self._ending.remove(live)
            self.state_changed.emit()
            return
        self._live = None
        entry = live.entry
        if error is not None and not isinstance(error, Cancelled):
            self.tell(_lost(error, entry) if isinstance(error, Lost) else message_of(error))
        if not entry.frames:
            self._runs.remove(entry)
        self.state_changed.emit()
        self._tell_heading(entry)
        self._tell_signs(live)
        self.finished.emit(entry)

    def _tell_heading(self, entry: RunEntry) -> None:
        """Say where it is not known which way the person faces, or was known late."""
        if (words := entry.heading) is not None:
            kind = "warning" if words.undecided else "note"
            self.tell(Message(kind, words.what, entry.name, words.remedy))

    def _tell_signs(self, live: LiveRun) -> None:
        """Say why nobody was tracked, where that is so, or that nothing fits."""
        entry, frames = live.entry, live.entry.frames.values()
        if entry.warnings:
            what = "; ".join(entry.warnings)
            self.tell(Message("warning", what, entry.name, CHECK))
        if not frames or any(frame.tracked for frame in frames):
            return
        causes = Untracked(live.recording, live.settings).take(frames).causes()
        self.tell(
            Message(
                "warning",
                "no frame of the run has a tracked person",
                entry.name,
                " ".join(cause.sentence() for cause in causes),
            )
        )


def _lost(error: Lost, entry: RunEntry) -> Message:
    return Message(
        "error",
        str(error),
        entry.name,
        "The frames tracked so far are kept. To continue, go to the last of them and run the "
        "tracker from there. If it happens again, free memory by closing other programs.",
    )
