"""The tracker at work: run, pause, step, one iteration, from here, a selection."""

import dataclasses
import time
from dataclasses import dataclass
from functools import partial
from typing import Any

from PySide6.QtCore import QElapsedTimer

from stereotrack_core.body.model import body_of_subject
from stereotrack_core.errors import Cancelled
from stereotrack_core.experiments import run_process
from stereotrack_core.project.runs import place_for_run
from stereotrack_core.recording.description import Recording
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
from .changes import Changes, Part
from .keypoints import KeypointPresenter
from .project import ProjectPresenter
from .runs import RunEntry, RunList

UPDATE_MS = 50
_LOST = (
    "The frames tracked so far are kept. To continue, go to the last of them and run the tracker "
    "from there. If it happens again, free memory by closing other programs."
)


@dataclass(frozen=True)
class Chosen:
    """What is tracked with: a preset, its values, and the values as they are."""

    preset: str
    base: Settings
    settings: Settings


class LiveRun:
    """A run that a process tracks, as far as the window knows."""

    def __init__(self, entry: RunEntry, run: run_process.RunTask, process: TaskProcess) -> None:
        self.entry, self.recording, self.settings = entry, run.recording, run.spec.settings
        self._spec = run.spec
        self.detects = run.spec.keypoints is None and detects_first(run.recording, self.settings)
        """Whether it detects keypoints in mono views before its first frame."""
        self.held = False
        """Whether it waits for leave to go on, with every frame fetched."""
        self.progress: run_process.Preparing | None = None
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
        self.order(run_process.Allow(frames, self._number))

    def hear(self, word: Any) -> None:
        match word:
            case run_process.Preparing():
                if self.progress is None or word.stage != self.progress.stage:
                    self._stage_begun = time.monotonic()
                self.progress = word
            case run_process.Prepared():
                self.entry.body, self.entry.origin = word.body, word.origin
            case run_process.Tracked():
                self.waiting.append(word.frame)
                self.entry.wall_seconds, self.progress = word.seconds, None
                if self._first_seconds is None:
                    self._first_seconds = word.seconds
            case run_process.Held():
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

    @property
    def preparing_share(self) -> float:
        """Share done of a stage before the first frame, 0 to 1."""
        return self.progress.done / max(self.progress.count, 1) if self.progress else 0.0

    def preparing_words(self) -> str:
        """``learning the background, 40 %, about 3 s left``."""
        progress = self.progress
        if progress is None:
            return "" if self.entry.frames else "starting"
        far = how_far(self.preparing_share, time.monotonic() - self._stage_begun)
        return f"{progress.stage}, {far}" if far else progress.stage

    def left_words(self) -> str:
        """``about 40 s left``; empty where nobody knows it yet."""
        done, first = len(self.entry.frames) - 1, self._first_seconds
        if done < 1 or first is None:
            return ""
        each = (self.entry.wall_seconds - first) / done
        return time_left(each * (len(self.entry.wanted) - done - 1))


class TrackPresenter:
    """Controls the tracker and collects what it finds, at most 20 times a second."""

    def __init__(
        self,
        changes: Changes,
        project: ProjectPresenter,
        runs: RunList,
        keypoints: KeypointPresenter,
        process: TaskProcess,
        tell: Tell,
    ) -> None:
        self._changes, self._project, self._runs = changes, project, runs
        self._keypoints, self._process, self.tell = keypoints, process, tell
        self.live: LiveRun | None = None
        self._ending: list[LiveRun] = []
        self._depths = False
        self.preset = "accurate"
        self.settings = self.base = preset(self.preset)
        self._since = QElapsedTimer()
        self._since.start()
        self._timer = later(changes, self._collect)

    @property
    def entry(self) -> RunEntry | None:
        return self.live.entry if self.live is not None else None

    @property
    def running(self) -> bool:
        """Whether the tracker works at this moment, or has frames that are not fetched yet."""
        return self.live is not None and not self.live.held

    @property
    def paused(self) -> bool:
        return self.live is not None and self.live.held

    def holds(self, entry: RunEntry) -> bool:
        """Whether a run is in progress, or has been stopped and may still get a frame."""
        return any(live.entry is entry for live in (self.live, *self._ending) if live is not None)

    @property
    def chosen(self) -> Chosen:
        return Chosen(self.preset, self.base, self.settings)

    def name_of(self, settings: Settings) -> str:
        """What a run with these settings is called: ``fast, iterations 3``."""
        changes = changes_in_words(self.base, settings)
        return f"{self.preset}, {changes}" if changes else self.preset

    def choose(self, name: str, settings: Settings) -> None:
        """Take all values from a preset, for the next run or step."""
        self.take(Chosen(name, settings, settings))

    def take(self, chosen: Chosen) -> None:
        self.preset, self.base, self.settings = chosen.preset, chosen.base, chosen.settings
        self._changes.tell(Part.SETTINGS)

    @property
    def stale(self) -> bool:
        return self.live is not None and self.live.settings != self.settings

    def begin(
        self, recording: Recording, frames: range, init: FirstPose, *, allowed: float = float("inf")
    ) -> RunEntry:
        """Begin a new run; the one in progress ends and keeps what it has."""
        self.stop()
        subject, project = self._project.subject(), self._project.project
        body = body_of_subject(subject, self.settings.body)
        name = self._runs.next_name(self.name_of(self.settings))
        entry = RunEntry(name, self.preset, self.settings, body, frames)
        if project is not None and not project.read_only:
            entry.journal = place_for_run(project.path)
        seen = self._keypoints.for_run(self.settings, frames)
        spec = RunSpec(self.settings, self.preset, frames=frames, init=init, keypoints=seen)
        # the tracker never sees the truth
        unaided = dataclasses.replace(recording, reference=None, subject=subject)
        task = run_process.RunTask(unaided, spec, entry.journal, run_process.Allow(allowed, 0))
        live = self.live = LiveRun(entry, task, self._process)
        live.task.told.connect(partial(self._on_told, live))
        live.task.ended.connect(partial(self._on_ended, live))
        live.order(run_process.Show(self._depths))
        live.task.start()
        self._runs.add(entry)
        self._changes.tell(Part.TRACKING)
        return entry

    def go_on(self, allowed: float = float("inf")) -> None:
        """Go on with the run in progress; 0: hold after the frame in work."""
        if self.live is not None:
            self.live.allow(allowed)
            self._changes.tell(Part.TRACKING)

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
        live = self.live
        if live is not None:
            live.task.cancel()
            self._ending.append(live)
        if at_once and self._ending:
            for ended in self._ending:
                ended.task.give_up()
            self._process.end()
        self._collect()
        self.live = None
        if live is not None and not live.entry.frames:
            self._runs.remove(live.entry)
        if at_once:
            for ended in self._ending:
                ended.end()
            self._ending.clear()
        if live is not None:
            self._changes.tell(Part.TRACKING)

    def show_depths(self, *, shown: bool) -> None:
        """Have every frame come with its views' depth images, or without."""
        if shown != self._depths:
            self._depths = shown
            if self.live is not None:
                self.live.order(run_process.Show(shown))

    def _on_told(self, live: LiveRun, words: list[Any]) -> None:
        for word in words:
            live.hear(word)
            self._follow(live, word)

    def _follow(self, live: LiveRun, word: Any) -> None:
        match word:
            case run_process.Tracked():
                if not self._timer.isActive():
                    self._timer.start(max(0, UPDATE_MS - self._since.elapsed()))
            case run_process.Held():
                self._collect()
                if word.cloud is not None and live is self.live:
                    self._changes.tell(Part.RESTED, word.cloud)
                self._changes.tell(Part.TRACKING)
            case run_process.Preparing() | run_process.Prepared() if live is self.live:
                self._changes.tell(Part.TRACKING)
                seen = (
                    word.origin.spec.keypoints if isinstance(word, run_process.Prepared) else None
                )
                if live.detects and seen is not None:
                    self._keypoints.remember(live.entry.wanted, seen)

    def _collect(self) -> None:
        """Take what has come, and show the newest frame of the run in progress."""
        self._timer.stop()
        self._since.start()
        for ended in self._ending:
            ended.taken()
        frames = self.live.taken() if self.live is not None else []
        if frames:
            self._changes.tell(Part.RUN_FRAMES)
            self._changes.tell(Part.TRACKED, frames[-1])

    def _on_ended(self, live: LiveRun) -> None:
        error = live.task.error
        self._collect()
        live.end()
        if live is not self.live:
            self._ending.remove(live)
            self._changes.tell(Part.TRACKING)
            return
        self.live = None
        entry = live.entry
        if error is not None and not isinstance(error, Cancelled):
            lost = Message("error", str(error), entry.name, _LOST)
            self.tell(lost if isinstance(error, Lost) else message_of(error))
        if not entry.frames:
            self._runs.remove(entry)
        self._changes.tell(Part.TRACKING)
        self._tell_signs(live)
        self._changes.tell(Part.RUN_ENDED, entry)

    def _tell_signs(self, live: LiveRun) -> None:
        """Say if the heading is open, and why nobody was tracked, or that nothing fits."""
        entry, frames = live.entry, live.entry.frames.values()
        if (words := entry.heading) is not None:
            kind = "warning" if words.undecided else "note"
            self.tell(Message(kind, words.what, entry.name, words.remedy))
        if entry.warnings:
            what = "; ".join(entry.warnings)
            self.tell(Message("warning", what, entry.name, CHECK))
        if not frames or any(frame.tracked for frame in frames):
            return
        causes = Untracked(live.recording, live.settings).take(frames).causes()
        what, why = "no frame of the run has a tracked person", (one.sentence() for one in causes)
        self.tell(Message("warning", what, entry.name, " ".join(why)))
