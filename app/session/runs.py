"""The runs of the open recording: which there are, which are shown, and how."""

from __future__ import annotations

import itertools
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np

from stereotrack_core.arrays import IntArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import hanging_pose
from stereotrack_core.errors import InputError
from stereotrack_core.experiments import run_process
from stereotrack_core.project.runs import RunFacts
from stereotrack_core.recording.landmarks import LandmarkTrajectory
from stereotrack_core.tracking import run_checks
from stereotrack_core.tracking.detecting import detects_first
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.frame import (
    LOOKED_AGAIN,
    Origin,
    Run,
    TrackedFrame,
    cloudless,
    run_of,
    seen_by_frame,
)
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.repeating import stored_spec
from stereotrack_core.tracking.run_spec import RunSpec
from stereotrack_core.tracking.stored import body_of_run, pose_of_run
from stereotrack_core.tracking.tuning.trial import Trial
from stereotrack_core.worker_processes import TaskProcess

from .changes import Part, TellChange
from .jobs import NewestJob, TaskList, how_far, time_left

_BOTH = Part.RUNS | Part.ACTIVE_RUN
RunStyle: TypeAlias = Literal["solid", "dash", "dot", "dashdot"]
_OTHERS: tuple[RunStyle, ...] = ("dash", "dot", "dashdot")


@dataclass(eq=False)
class RunEntry:
    """One run, growing while the tracker works; read and changed in the window's thread alone."""

    name: str
    preset: str
    settings: Settings | None  # None for a run from a file of another version
    body: BodyModel
    wanted: range
    frames: dict[int, TrackedFrame] = field(default_factory=dict)
    visible: bool = True
    path: Path | None = None  # file that it came from or was saved to
    stored: Run | None = None
    origin: Origin | None = None  # where its frames come from; known when tracking has begun
    wall_seconds: float = 0.0  # time that the tracker has worked on it, without pauses
    kind: Literal["run", "trial"] = "run"
    """A trial is what some stretch would look like with other settings; it
    is gone when it is dismissed, unless it is made the active run."""
    trial: Trial | None = None  # how it was tried
    kept: str = ""  # name under which the project keeps it; empty where it does not
    facts: RunFacts | None = None
    """What the project says about it; its frames are there when they have been read."""
    warnings: tuple[str, ...] = ()  # what its signs say that is wrong with it
    begun: int = 0  # how often its frames have begun again
    journal: Path | None = None
    """File that its frames go to while it is tracked, until the project keeps it."""
    _stated: tuple[Settings | None, ...] = ()

    @property
    def waiting(self) -> bool:
        """Whether the project keeps it and its frames have not been read."""
        return bool(self.kept) and self.facts is not None and not self.frames

    def put(self, frame: TrackedFrame) -> None:
        """Take the next frame; one that comes again takes the place of all from it on."""
        if self.frames and frame.frame <= next(reversed(self.frames)):
            self.frames = {k: one for k, one in self.frames.items() if k < frame.frame}
            self.begun += 1
        self.frames[frame.frame] = frame

    @property
    def meta(self) -> Mapping[str, Any]:
        """Facts that it states of itself, such as its seed; empty while there are none."""
        told = self.stored or self.origin
        return {} if told is None else told.meta

    @property
    def heading(self) -> run_checks.HeadingWords | None:
        """What is to be said of the way that the person faces."""
        return run_checks.heading_words(self.meta.get(run_checks.HEADING))

    @property
    def looked_again(self) -> list[tuple[int, int]]:
        """First and last frames of stretches that a second look has changed."""
        return [(first, last) for first, last in self.meta.get(LOOKED_AGAIN, ())]

    def at(self, frame: int) -> TrackedFrame | None:
        return self.frames.get(frame)

    def numbers(self) -> IntArray:
        """Frames that the run has, ascending (F,)."""
        return np.array(sorted(self.frames), dtype=np.int64)

    def ordered(self) -> Iterator[TrackedFrame]:
        return (self.frames[k] for k in sorted(self.frames))

    def trajectory(self) -> LandmarkTrajectory:
        points = [frame.landmarks for frame in self.ordered()]
        stacked = np.stack(points) if points else np.empty((0, 9, 3))
        return LandmarkTrajectory(self.numbers(), stacked)

    def run(self) -> Run | None:
        """Put the run together to be saved; None while nothing is known of its origin."""
        if self.stored is not None:
            return self.stored
        if self.origin is None:
            return None
        run = run_of(list(self.ordered()), self.origin)
        more = {"wall_seconds": self.wall_seconds, run_checks.WARNINGS: list(self.warnings)}
        return replace(run, meta={**run.meta, **more})

    def spec(self) -> RunSpec | None:
        """How it was made; None where that is not known, or a file of another version says less."""
        if self.origin is not None:
            return replace(self.origin.spec, seen=seen_by_frame(self.frames.values()))
        try:
            return None if self.stored is None else stored_spec(self.stored).spec
        except InputError:
            return None

    def made_with(self) -> Settings | None:
        """Its settings; None where a file of another version does not say."""
        if self.settings is not None or self.stored is None:
            return self.settings
        if not self._stated:  # commands ask all the time, and reading takes milliseconds
            spec = self.spec()
            self._stated = (None if spec is None else spec.settings,)
        return self._stated[0]

    def now(self) -> RunEntry:
        """What it holds now; work in another thread is given this, never the entry itself."""
        return replace(self, frames=dict(self.frames))

    def frames_per_second(self) -> float | None:
        """How fast it was tracked; None where that is not known."""
        return len(self.frames) / self.wall_seconds if self.wall_seconds > 0 else None


class RunList:
    """Runs in the order in which they were made; one of them is active."""

    def __init__(self, tell: TellChange) -> None:
        self.tell = tell
        """Tells parts that are new, also where a run in the list is known better than before."""
        self.entries: tuple[RunEntry, ...] = ()
        self.active: RunEntry | None = None
        self._chosen: RunEntry | None = None
        self._before: RunEntry | None = None  # the run that was active before this one
        self._made = 0

    @property
    def front(self) -> RunEntry | None:
        """The trial that is chosen, else the newest."""
        trials = [one for one in self.entries if one.kind == "trial"]
        return self._chosen if self._chosen in trials else trials[-1] if trials else None

    def bring_to_front(self, entry: RunEntry | None) -> None:
        before, self._chosen = self.front, entry
        if self.front is not before:
            self.tell(Part.RUNS)

    def style(self, entry: RunEntry) -> RunStyle:
        """Line style of a run: the active one is solid, the others that are shown take turns."""
        if entry is self.active:
            return "solid"
        others = [one for one in self.entries if one.visible and one is not self.active]
        place = next((k for k, one in enumerate(others) if one is entry), 0)
        return _OTHERS[place % len(_OTHERS)]

    def shown_beside(self) -> tuple[RunEntry, ...]:
        return tuple(one for one in self.entries if one.visible and one is not self.active)

    def next_name(self, settings: str) -> str:
        """Name for a new run, with a number that no other has; `settings` say how it is made."""
        taken = {entry.name.partition(":")[0] for entry in self.entries}
        self._made = next(n for n in itertools.count(self._made + 1) if str(n) not in taken)
        return f"{self._made}: {settings}"

    def free_name(self, wanted: str) -> str:
        """Name that is wanted, or one with a number behind it where another run has it."""
        taken = {entry.name for entry in self.entries}
        others = (f"{wanted} ({number})" for number in range(2, len(taken) + 3))
        return next(name for name in (wanted, *others) if name not in taken)

    def add(self, entry: RunEntry, *, active: bool = True) -> None:
        self.entries = (*self.entries, entry)
        if active:
            self._before, self.active = self.active, entry
        self.tell(_BOTH if active else Part.RUNS)

    def remove(self, entry: RunEntry) -> None:
        """Take a run from the list; files are not touched."""
        self.entries = tuple(kept for kept in self.entries if kept is not entry)
        self._chosen = None if self._chosen is entry else self._chosen
        was_active = self.active is entry
        if was_active:
            self.active = self.entries[-1] if self.entries else None
        self.tell(_BOTH if was_active else Part.RUNS)

    def clear(self) -> None:
        self.entries, self.active, self._chosen, self._made = (), None, None, 0
        self.tell(_BOTH)

    def activate(self, entry: RunEntry) -> None:
        if entry is not self.active:
            self._before, self.active = self.active, entry
            entry.visible = True
            self.tell(_BOTH)

    def show(self, entry: RunEntry, *, visible: bool) -> None:
        if entry.visible != visible:
            entry.visible = visible
            self.tell(Part.RUNS)

    def toggle_active(self) -> None:
        if self.active is not None:
            self.show(self.active, visible=not self.active.visible)

    def activate_next(self) -> None:
        entries = self.entries
        if self.active is not None:
            self.activate(entries[(entries.index(self.active) + 1) % len(entries)])

    @property
    def before(self) -> RunEntry | None:
        """The run that was active before this one, or the next one where that is gone."""
        others = [one for one in self.entries if one is not self.active]
        return self._before if self._before in others else others[0] if others else None

    def activate_last(self) -> None:
        if (before := self.before) is not None:
            self.activate(before)

    def rename(self, entry: RunEntry, name: str) -> None:
        if name.strip() and name != entry.name:
            entry.name = name.strip()
            self.tell(Part.RUNS)


def entry_of_run(run: Run, path: Path) -> RunEntry:
    """Make a list entry of a stored run.

    Raises InputError where its states are not those of a body.
    """
    frames = frames_of_run(run)
    numbers = run.frame
    wanted = range(int(numbers[0]), int(numbers[-1]) + 1) if len(numbers) else range(0)
    preset = str(run.meta.get("preset", ""))
    return RunEntry(
        path.stem, preset, None, body_of_run(run), wanted, frames, path=path, stored=run,
        wall_seconds=float(run.meta.get("wall_seconds") or 0.0),
    )  # fmt: skip


def frames_of_run(run: Run) -> dict[int, TrackedFrame]:
    """Frames of a stored run by their numbers.

    Raises InputError where its states are not those of a body.
    """
    return {int(k): _stored_frame(run, i) for i, k in enumerate(run.frame)}


def _stored_frame(run: Run, i: int) -> TrackedFrame:
    pose = pose_of_run(run, i)
    frame = int(run.frame[i])
    estimate = Estimate(
        tracked=pose is not None,
        reason="" if pose is not None else "the run has no pose in this frame",
        pose=pose if pose is not None else hanging_pose(np.zeros(3)), x=run.x[i], P=run.P[i],
        unexplained_fraction=float(run.unexplained_fraction[i]), residual=float(run.residual[i]),
        innovation=float(run.innovation[i]), limb_sigma_deg=run.limb_sigma_deg[i],
        limb_lost=run.limb_lost[i],
    )  # fmt: skip
    seconds = dict(zip(run.stage_names, run.seconds[i].tolist(), strict=True))
    return TrackedFrame(
        frame, estimate, run.landmarks[i], cloudless(frame), seconds, keypoints=run.seen(frame)
    )


class LiveRun:
    """A run that a process tracks, as far as the window knows."""

    def __init__(
        self, entry: RunEntry, run: run_process.RunTask, process: TaskProcess, tasks: TaskList
    ) -> None:
        self.entry, self.recording, self.settings = entry, run.recording, run.spec.settings
        self._spec = run.spec
        self.detects = run.spec.keypoints is None and detects_first(run.recording, self.settings)
        """Whether it detects keypoints in mono views before its first frame."""
        self.held = False  # whether it waits for leave to go on, with every frame fetched
        self.start_words = ""  # where its first pose is from, if another run has given it
        self.progress: run_process.Preparing | None = None
        """Progress of what comes before the first frame."""
        self.waiting: list[TrackedFrame] = []
        self._run, self._process, self.job = run, process, NewestJob(tasks, quiet=True)
        self._number = run.allowed.number
        self._stage_begun = 0.0
        self._first_seconds: float | None = None

    def order(self, order: object) -> None:
        self._process.order(self._run, order)

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
                origin, words = word.origin, self.start_words
                meta = {**origin.meta, "init": words} if words else origin.meta
                self.entry.body, self.entry.origin = word.body, replace(origin, meta=meta)
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
        self.entry.warnings = run_checks.run_warnings(
            frames, self.entry.body, self.recording, self._spec
        )

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
