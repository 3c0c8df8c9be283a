"""One run, kept frame by frame until it is complete, with an account of what happened."""

import dataclasses
import time
from collections.abc import Callable
from contextlib import closing, nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from stereotrack_core.errors import Cancelled
from stereotrack_core.evaluation.summary import statistics
from stereotrack_core.interop.run_journal import RunJournal, Wish
from stereotrack_core.recording.description import Recording
from stereotrack_core.tracking import run_checks
from stereotrack_core.tracking.frame import LOOKED_AGAIN, Replaced, Run, TrackedFrame
from stereotrack_core.tracking.lengths_fit import ESTIMATING_LENGTHS, LENGTH_FRAMES
from stereotrack_core.tracking.repair import REPAIRED
from stereotrack_core.tracking.run import Advance, track
from stereotrack_core.tracking.run_spec import Hooks, RunSpec
from stereotrack_core.tracking.second_look import LOOKING_AGAIN
from stereotrack_core.tracking.unfinished import INCOMPLETE, UnfinishedRun


@dataclass(frozen=True, eq=False)
class TrackedRun:
    """A run, and how it came about."""

    run: Run  # its meta states the wall time as ``wall_seconds``
    wanted: int  # frames that were asked for
    gaps: tuple[run_checks.Gap, ...]
    blind: tuple[
        run_checks.Blindness, ...
    ]  # where a used view gave nothing; also in the run's meta
    stopped: bool  # whether it was stopped before the last frame
    untracked: run_checks.Untracked  # the frames that were not tracked, and why
    changed: tuple[int, ...] = ()  # frames tracked again that came out otherwise

    @property
    def nothing(self) -> bool:
        """Whether no frame was tracked at all."""
        return not self.run.tracked.any()

    def to_dict(self) -> dict[str, Any]:
        """The same as plain data."""
        run, tracked = self.run, self.run.tracked
        seconds = float(run.meta["wall_seconds"])
        return {
            "recording": run.meta.get("recording"),
            "preset": run.meta.get("preset"),
            "frames": len(run.frame),
            "tracked": int(tracked.sum()),
            "not_tracked": self.gaps,
            "blind_views": self.blind,
            "heading": run.meta.get(run_checks.HEADING),
            "warnings": list(run.meta["warnings"]),
            "untracked_because": self.untracked.causes,
            "points": self.untracked.counts,
            "smoothed": bool(run.meta.get("smoothed", False)),
            "bridged": list(run.meta.get("bridged", [])),
            "repaired": list(run.meta.get(REPAIRED, [])),
            LOOKED_AGAIN: list(run.meta.get(LOOKED_AGAIN, [])),
            "stopped": self.stopped,
            "resumed_at": list(run.meta.get("resumed_at", [])),
            "changed": list(self.changed),
            "frames_per_second": len(run.frame) / seconds if seconds > 0 else None,
            "mean_unexplained_fraction": statistics(run.unexplained_fraction[tracked]).mean,
            "mean_residual_mm": 1000.0 * statistics(run.residual[tracked]).mean,
            "median_stage_ms": {
                name: 1000.0 * float(np.median(own)) if len(own) else float("nan")
                for name, own in zip(run.stage_names, run.seconds.T, strict=True)
            },
        }


@dataclass
class _Course:
    """What happens frame by frame, shown and noted."""

    show: Callable[[int, str], None]
    stopped: Callable[[], bool]
    before: int
    begun: UnfinishedRun | None
    frames: list[TrackedFrame]  # so far, without clouds
    changed: list[int] = field(default_factory=list)
    steps: int = 0

    def prepare(self, stage: str, _done: int, _count: int) -> None:
        """A part of what is no next frame: of what comes before the first, or of a second look."""
        if stage == ESTIMATING_LENGTHS:
            self.steps += 1
            self.show(self.steps, "")
        elif stage == LOOKING_AGAIN:
            self.show(self.before + len(self.frames), stage)
        if self.stopped():
            raise Cancelled

    def note(self, gained: Replaced) -> None:
        """New frames of the run, in the place of all from the first of them on."""
        if self.frames and gained.first <= self.frames[-1].frame:
            self.begun, self.changed = None, []  # what was begun before is done again as well
        self.frames = gained.into(self.frames)
        for frame in gained.frames:
            if self.begun is not None and self.begun.changed_by(frame):
                self.changed.append(frame.frame)
            self.show(self.before + len(self.frames), "")


@dataclass(frozen=True, eq=False)
class TrackPlan:
    """Everything that a run shall be."""

    recording: Recording  # with the subject that is tracked
    spec: RunSpec
    count: int | None = None  # frames after which it ends; None: with those of the spec
    begun: UnfinishedRun | None = None  # the run that is gone on with

    @property
    def wanted(self) -> int:
        """Frames of the run."""
        return self.count or len(self.spec.frames_of(0))

    @property
    def before(self) -> int:
        """Frames of a first pass that estimates lengths."""
        passes = self.spec.settings.body.proportions == "sequence" and self.begun is None
        return min(LENGTH_FRAMES, len(self.spec.frames_of(0))) if passes else 0


def track_recording(
    plan: TrackPlan,
    *,
    part: Path | None = None,
    on_step: Callable[[int, str], None] = lambda *_: None,
    cancelled: Callable[[], bool] = lambda: False,
) -> TrackedRun:
    """Track, keep every frame at once, and keep what there is when it is stopped.

    Raises Cancelled before the first frame. Every frame goes to the file `part` at once
    (:class:`RunJournal`). `on_step` is told how many frames are done, those of a first pass
    included, and of a second look.
    """
    spec, begun = plan.spec, plan.begun
    started = time.perf_counter() - (0.0 if begun is None else begun.wall_seconds)

    def clock() -> float:
        return time.perf_counter() - started

    done = [] if begun is None else [frame.without_cloud() for frame in begun.done]
    course = _Course(on_step, cancelled, plan.before, begun, done)
    journal = None if part is None else RunJournal(part, clock, Wish(spec.smooth, plan.count))

    def note(advance: Advance) -> None:
        if journal is not None:
            journal.keep(advance)
        course.note(advance.gained)

    with nullcontext() if journal is None else closing(journal):
        run = track(
            dataclasses.replace(plan.recording, reference=None),  # the tracker never sees the truth
            spec,
            on_advance=note,
            hooks=Hooks(on_preparing=course.prepare, cancelled=cancelled),
            begun=begun,
            count=plan.count,
        )
    untracked = run_checks.untracked_in(course.frames, plan.recording, spec.settings)
    return _tracked(run, course, untracked, clock(), plan.wanted)


def _tracked(
    run: Run, course: _Course, untracked: run_checks.Untracked, seconds: float, wanted: int
) -> TrackedRun:
    bridged = {*run.meta["bridged"], *run.meta.get(REPAIRED, ())}
    gone = [one for one in course.frames if not (one.tracked or one.frame in bridged)]
    blind = run_checks.blind_stretches(course.frames)
    facts = {INCOMPLETE: len(run.frame) < wanted, "blind": [vars(one) for one in blind]}
    return TrackedRun(
        run=run.stating(wall_seconds=seconds, **facts),
        wanted=wanted,
        gaps=run_checks.gaps_of([(one.frame, one.reason) for one in gone]),
        blind=blind,
        stopped=len(run.frame) < wanted,
        untracked=untracked,
        changed=tuple(course.changed),
    )
