"""The tracker at work: run, pause, step, from here, a selection; what the next run is made with."""

from __future__ import annotations

import dataclasses
import time
from dataclasses import dataclass
from functools import partial
from typing import Any

from stereotrack_core.body.model import body_of_subject
from stereotrack_core.body.pose import Pose
from stereotrack_core.experiments import run_process
from stereotrack_core.parameters import value_text
from stereotrack_core.project.runs import place_for_run
from stereotrack_core.recording.description import Recording
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run_checks import CHECK, untracked_in
from stereotrack_core.tracking.run_spec import FirstPose, RunSpec
from stereotrack_core.tracking.tuning.process import KeptRecording
from stereotrack_core.tracking.tuning.stages import changed_names, changes_in_words
from stereotrack_core.worker_processes import Lost

from .base import Base
from .changes import Part
from .edits import WindowEdit
from .jobs import Job, Task
from .keypoints import KeypointPresenter
from .messages import Message, message_of
from .project import ProjectPresenter
from .runs import LiveRun, RunEntry

UPDATE_MS = 50
_LOST = (
    "The frames tracked so far are kept. To continue, go to the last of them and run the tracker "
    "from there. If it happens again, free memory by closing other programs."
)


FIRST_POSES: dict[str, tuple[str, str]] = {
    "tpose": ("T pose", "Start with the person facing north, both arms stretched out sideways."),
    "auto": ("Found automatically", "Start with whatever pose the person has in the first frame."),
    **{
        f"auto {degrees}": (
            f"Found automatically, facing {way}",
            f"Start with whatever pose the person has in the first frame, facing {way} "
            f"(the world's {axis}).",
        )
        for degrees, way, axis in (
            (0, "north", "y axis"),
            (90, "east", "x axis"),
            (180, "south", "negative y axis"),
            (270, "west", "negative x axis"),
        )
    },
}
"""Where a run's first pose may come from, as a title and a sentence."""


@dataclass(frozen=True, eq=False)
class KnownStart:
    """First pose of a run that another one gives."""

    pose: Pose
    run: RunEntry
    words: str  # ``from run 1: accurate, frame 48``

    @staticmethod
    def of(run: RunEntry, frame: int) -> KnownStart | None:
        """The pose in a frame; None if the run has none there."""
        tracked = run.at(frame)
        if tracked is None or tracked.pose is None:
            return None
        return KnownStart(tracked.pose, run, f"from run {run.name}, frame {frame}")


@dataclass(frozen=True)
class Chosen:
    """What is tracked with: a preset, its values, and the values as they are."""

    preset: str
    base: Settings
    settings: Settings


class TrackPresenter:
    """Controls the tracker, follows it with the views, and collects at most 20 times a second."""

    def __init__(self, base: Base, project: ProjectPresenter, keypoints: KeypointPresenter) -> None:
        self._changes, self._tasks, self._edits = base.changes, base.tasks, base.edits
        self._document, self._runs, self._tell = base.document, base.runs, base.tell
        self._project, self.keypoints = project, keypoints
        self._view_state, self._process = base.view_state, base.processes.run
        self._kept: KeptRecording | None = None
        self.live: LiveRun | None = None
        self._ending: list[LiveRun] = []
        self._depths = False
        self._despite_errors: Recording | None = None
        self.preset = "accurate"
        self.settings = self.base = preset(self.preset)
        self.first_pose: FirstPose = "auto"
        """Where the first pose comes from when no run has one: a key of :data:`FIRST_POSES`, or a
        pose."""
        self.follow = True  # whether the views show the newest frame
        self._collected = time.monotonic()
        self._timer = base.later(self._collect, UPDATE_MS)

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

    @property
    def kept(self) -> KeptRecording | None:
        """The open recording with the subject of the next run, for tasks that share clouds."""
        recording, kept = self._document.recording, self._kept
        if recording is None:
            return None
        subject, mono = self._project.subject(), self.keypoints.mono_views(recording)
        if kept is None or (kept.recording.subject, kept.mono) != (subject, mono):
            # the tracker never sees the truth
            unaided = dataclasses.replace(recording, reference=None, subject=subject)
            kept = self._kept = KeptRecording(unaided, mono)
        return kept

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

    # ---- what the next run is tracked with

    def choose(self, name: str, settings: Settings) -> None:
        """Take all values from a preset, for the next run or step."""
        self.put(Chosen(name, settings, settings))

    def put(self, chosen: Chosen) -> None:
        self.preset, self.base, self.settings = chosen.preset, chosen.base, chosen.settings
        self._changes.tell(Part.SETTINGS)

    def use(self, settings: Settings, words: str = "") -> None:
        self.take(Chosen(self.preset, self.base, settings), words)

    def take(self, chosen: Chosen, words: str = "") -> None:
        """Use other settings, perhaps of another preset; `words` say what that is."""
        before = self.chosen
        if chosen == before:  # nothing is another, but it is asked for again
            self.put(chosen)
            return
        names = changed_names(before.settings, chosen.settings)
        alone = len(names) == 1 and not words
        self._edits.do(
            WindowEdit(
                words or _words(chosen, names), self.put, before, chosen,
                "tune", "parameters", slot=("parameter", *names) if alone else None,
            )
        )  # fmt: skip

    # ---- commands

    def run(self) -> None:
        """Go on with a run that is paused, or begin one; settings that have changed apply."""
        self._go_on_or_begin(float("inf"))

    def step(self) -> None:
        self._go_on_or_begin(1)

    def run_from_here(self) -> None:
        self._begin(range(self._document.frame, self._document.frame_count), float("inf"))

    def run_selection(self) -> KnownStart | None:
        """Track the selected frames; where the first pose is from, if another run has given it."""
        selected = self._view_state.selection
        return self._begin(selected, float("inf")) if selected else None

    def _go_on_or_begin(self, allowed: float) -> None:
        self._document.pause()
        entry = self.entry
        if entry is None or self.live is None:
            self._begin(range(self._document.frame_count), allowed)
        elif self.live.settings != self.settings:
            # settings belong to a run as a whole: what follows is another one
            wanted, done = entry.wanted, entry.frames
            start = KnownStart.of(entry, max(done)) if done else None
            self._begin(wanted[len(done) :] or range(wanted.stop), allowed, start)
        else:
            self.go_on(allowed)

    def _begin(
        self, frames: range, allowed: float, start: KnownStart | None = None
    ) -> KnownStart | None:
        recording = self._document.recording
        if recording is None or not len(frames) or self._told_of(recording, frames, allowed, start):
            return None
        start = start or self._known_start(frames.start)
        self._document.pause()
        init = self.first_pose if start is None else start.pose
        self.begin(recording, frames, init, allowed=allowed, start=start)
        if start is not None:
            self._changes.tell(Part.SAID, f"The initial pose is {start.words}.")
        return start

    def _told_of(
        self, recording: Recording, frames: range, allowed: float, start: KnownStart | None
    ) -> bool:
        """Say once why a recording should not be tracked; whether that was done now."""
        found = self._document.hindrances()
        if not found or self._despite_errors is recording:
            return False

        def nevertheless() -> None:
            self._despite_errors = recording
            if self._document.recording is recording:
                self._begin(frames, allowed, start)

        first, button = found[0], "Track nevertheless"
        what = f"it would not be tracked correctly: {first.what}"
        self._tell(Message("error", what, first.where, first.remedy, button, nevertheless))
        return True

    def _known_start(self, frame: int) -> KnownStart | None:
        """Pose of the active run just before a frame, or at it; the first frame starts anew."""
        active = self._runs.active
        if active is None or frame == 0:
            return None
        return KnownStart.of(active, frame - 1) or KnownStart.of(active, frame)

    # ---- the run in progress

    def begin(
        self,
        recording: Recording,
        frames: range,
        init: FirstPose,
        *,
        allowed: float = float("inf"),
        start: KnownStart | None = None,
    ) -> RunEntry:
        """Begin a new run; the one in progress ends and keeps what it has.

        `start` says where a pose as `init` is from.
        """
        self.stop()
        subject, project = self._project.subject(), self._project.project
        body = body_of_subject(subject, self.settings.body)
        name = self._runs.next_name(self.name_of(self.settings))
        entry = RunEntry(name, self.preset, self.settings, body, frames)
        if project is not None and not project.read_only:
            entry.journal = place_for_run(project.path)
        seen = self.keypoints.for_run(self.settings, frames)
        spec = RunSpec(self.settings, self.preset, frames=frames, init=init, keypoints=seen)
        # the tracker never sees the truth
        unaided = dataclasses.replace(recording, reference=None, subject=subject)
        task = run_process.RunTask(unaided, spec, entry.journal, run_process.Allow(allowed, 0))
        live = self.live = LiveRun(entry, task, self._process, self._tasks)
        live.start_words = "" if start is None else start.words
        live.order(run_process.Show(self._depths))
        work = partial(Task.in_process, process=self._process, todo=task)
        failed, ended = partial(self._on_failed, live), partial(self._on_ended, live)
        told = partial(self._on_told, live)
        live.job.run(Job("track", work, failed=failed, ended=ended, told=told))
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

        With `at_once` that frame is given up, and journals are let go before this returns, also
        those of runs that were stopped before.
        """
        live = self.live
        if live is not None:
            live.job.cancel()
            self._ending.append(live)
        if at_once and self._ending:
            for ended in self._ending:
                ended.job.give_up()
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
            match word:
                case run_process.Tracked():
                    if not self._timer.isActive():
                        waited = int(1000.0 * (time.monotonic() - self._collected))
                        self._timer.start(max(0, UPDATE_MS - waited))
                case run_process.Held():
                    self._collect()
                    if word.cloud is not None and live is self.live:
                        self._changes.tell(Part.RESTED, word.cloud)
                    self._changes.tell(Part.TRACKING)
                case run_process.Preparing() if live is self.live:
                    self._changes.tell(Part.TRACKING)
                case run_process.Prepared() if live is self.live:
                    self._changes.tell(Part.TRACKING)
                    if live.detects and (seen := word.origin.spec.keypoints) is not None:
                        self.keypoints.remember(live.entry.wanted, seen)

    def _collect(self) -> None:
        """Take what has come, and show the newest frame of the run in progress."""
        self._timer.stop()
        self._collected = time.monotonic()
        for ended in self._ending:
            ended.taken()
        frames = self.live.taken() if self.live is not None else []
        if frames:
            self._changes.tell(Part.RUN_FRAMES)
            self._changes.tell(Part.TRACKED, frames[-1])
            # It is shown when its cloud is kept. Who annotates clicks in the frame that they see.
            if self.follow and self._view_state.workspace != "annotate":
                self._document.go_to(frames[-1].frame)

    def _on_failed(self, live: LiveRun, error: Exception) -> None:
        if live is self.live:
            lost = Message("error", str(error), live.entry.name, _LOST)
            self._tell(lost if isinstance(error, Lost) else message_of(error))

    def _on_ended(self, live: LiveRun) -> None:
        self._collect()
        live.end()
        if live is not self.live:
            self._ending.remove(live)
            self._changes.tell(Part.TRACKING)
            return
        self.live = None
        entry = live.entry
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
            self._tell(Message(kind, words.what, entry.name, words.remedy))
        if entry.warnings:
            what = "; ".join(entry.warnings)
            self._tell(Message("warning", what, entry.name, CHECK))
        if not frames or any(frame.tracked for frame in frames):
            return
        causes = untracked_in(frames, live.recording, live.settings).causes
        what, why = "no frame of the run has a tracked person", (one.sentence() for one in causes)
        self._tell(Message("warning", what, entry.name, " ".join(why)))


def _words(chosen: Chosen, names: tuple[str, ...]) -> str:
    """``set loss_scale to 0.03``, for these parameters that have another value then."""
    if len(names) == 1:
        return f"set {names[0]} to {value_text(chosen.settings.values()[names[0]])}"
    if chosen.settings == chosen.base:
        return "revert all parameters"
    return f"set {len(names)} parameters"
