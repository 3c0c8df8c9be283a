"""Tracking with progress, a way to stop, and an account of what happened."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stereotrack_core.cli.output import Table, number
from stereotrack_core.cli.progress import progress, stoppable
from stereotrack_core.cli.tracking_gaps import Blindness, Gap, ViewProblems, gaps_of
from stereotrack_core.errors import Cancelled
from stereotrack_core.interop.run_journal import RunJournal, Wish
from stereotrack_core.tracking.run_spec import RunSpec
from stereotrack_core.tracking.unfinished import INCOMPLETE
from stereotrack_core.tracking.untracked import Untracked

if TYPE_CHECKING:
    from stereotrack_core.recording.description import Recording
    from stereotrack_core.tracking.frame import TrackedFrame
    from stereotrack_core.tracking.run import Run
    from stereotrack_core.tracking.settings import Settings
    from stereotrack_core.tracking.unfinished import UnfinishedRun


@dataclass(frozen=True, eq=False)
class TrackingJob:
    """A run, and how it came about.

    Attributes
    ----------
    run : Run
        Its meta states the wall time as ``wall_seconds``.
    wanted : int
        Frames that were asked for.
    gaps : tuple of Gap
    blind : tuple of Blindness
        Where a view gave nothing although it was used; also in the run's meta as ``blind``.
    stopped : bool
        Whether it was stopped before the last frame.
    untracked : Untracked
        The frames that were not tracked, and why.
    changed : tuple of int
        Frames that were tracked again to go on with the run, and came out otherwise.
    """

    run: Run
    wanted: int
    gaps: tuple[Gap, ...]
    blind: tuple[Blindness, ...]
    stopped: bool
    untracked: Untracked
    changed: tuple[int, ...] = ()

    @property
    def nothing(self) -> bool:
        """Whether no frame was tracked at all."""
        return not self.run.tracked.any()

    def facts(self) -> dict[str, Any]:
        """What the result says in JSON."""
        from stereotrack_core.evaluation.summary import statistics

        run, tracked = self.run, self.run.tracked
        seconds = float(run.meta["wall_seconds"])
        return {
            "recording": run.meta.get("recording"),
            "preset": run.meta.get("preset"),
            "frames": len(run.frame),
            "tracked": int(tracked.sum()),
            "not_tracked": self.gaps,
            "blind_views": self.blind,
            "warnings": list(run.meta["warnings"]),
            "untracked_because": self.untracked.causes(),
            "points": self.untracked.counts,
            "smoothed": bool(run.meta.get("smoothed", False)),
            "bridged": list(run.meta.get("bridged", [])),
            "stopped": self.stopped,
            "resumed_at": list(run.meta.get("resumed_at", [])),
            "changed": list(self.changed),
            "frames_per_second": len(run.frame) / seconds if seconds > 0 else None,
            "mean_unexplained_fraction": statistics(run.unexplained_fraction[tracked]).mean,
            "mean_residual_mm": 1000.0 * statistics(run.residual[tracked]).mean,
            "median_stage_ms": dict(
                zip(run.stage_names, 1000.0 * _median(run.seconds), strict=True)
            ),
        }

    @property
    def lengths(self) -> str:
        """Where the body's lengths come from."""
        if self.run.meta["parameters"].get("proportions") == "average":
            return "average"
        subject = self.run.meta.get("subject")
        if subject is None:
            return "average, there is no subject file; see stereotrack proportions"
        return str(subject.get("name") or "the recording's subject file")

    def table(self, title: str) -> Table:
        """What the result says to a person."""
        facts = self.facts()
        rows = [
            ("preset", str(facts["preset"])),
            ("frames", f"{facts['frames']} of {self.wanted}"),
            ("tracked", str(facts["tracked"])),
            ("unexplained fraction of the cloud", number(facts["mean_unexplained_fraction"], 3)),
            ("residual", f"{number(facts['mean_residual_mm'])} mm"),
            ("lengths of the body", self.lengths),
            ("frames per second", number(facts["frames_per_second"] or np.nan)),
        ]
        if facts["smoothed"]:
            rows.append(("smoothed, bridged frames", str(len(facts["bridged"]))))
        rows += [(f"not tracked {gap.first}:{gap.end}", gap.reason) for gap in self.gaps]
        rows += [(f"view {b.view} blind {b.first}:{b.end}", b.reason) for b in self.blind]
        return Table(title, ("what", ">value"), rows)


def _median(seconds: Any) -> Any:
    return np.median(seconds, axis=0) if len(seconds) else np.full(seconds.shape[1], np.nan)


class _Course:
    """What happens frame by frame, shown and noted."""

    def __init__(
        self,
        show: Callable[[int], None],
        stopped: Callable[[], bool],
        before: int,
        begun: UnfinishedRun | None,
        untracked: Untracked,
    ) -> None:
        self.reasons: list[tuple[int, str]] = []
        self.problems = ViewProblems()
        self.done = 0
        self.changed: list[int] = []
        self.untracked = untracked
        self._begun = begun
        self._show, self._stopped = show, stopped
        self._before, self._steps = before, 0
        for frame in () if begun is None else begun.done:
            self._take(frame)

    def prepare(self, _: TrackedFrame) -> None:
        """A frame of the first pass, from which lengths are estimated."""
        self._steps += 1
        self._show(self._steps)
        if self._stopped():
            raise Cancelled

    def replay(self, _: int) -> None:
        """A frame that is not tracked again."""
        if self._stopped():
            raise Cancelled

    def note(self, frame: TrackedFrame) -> None:
        """A frame of the run."""
        self._take(frame)
        if self._begun is not None and self._begun.changed_by(frame):
            self.changed.append(frame.frame)
        self._show(self._before + self.done)

    def _take(self, frame: TrackedFrame) -> None:
        self.done += 1
        self.problems.note(frame.frame, frame.cloud.problems)
        self.untracked.note(frame)
        if not frame.tracked:
            self.reasons.append((frame.frame, frame.reason))


def track_recording(
    recording: Recording,
    spec: RunSpec,
    *,
    count: int | None = None,
    part: Path | None = None,
    begun: UnfinishedRun | None = None,
) -> TrackingJob:
    """Track, show progress, and keep what there is when stopped with Ctrl-C.

    Raises :class:`Cancelled` when it is stopped before the first frame, while lengths are
    estimated.

    Parameters
    ----------
    recording : Recording
    spec : RunSpec
        With its frames.
    count : int, optional
        Tracking ends after so many of the frames, as when a run that was stopped is repeated.
    part : Path, optional
        Where every frame goes at once, and stays: see :class:`RunJournal`.
    begun : UnfinishedRun, optional
        What is there already, to go on with.
    """
    from stereotrack_core.tracking.pipeline import track

    frames = spec.frames or range(0)
    clock, wanted = _Clock(0.0 if begun is None else begun.wall_seconds), count or len(frames)
    before = _first_pass(spec.settings, frames) if begun is None else 0
    with (
        _journal(part, clock, Wish(spec.smooth, count)) as keeper,
        progress("Tracking", before + wanted) as show,
        stoppable() as stopped,
    ):
        course = _Course(show, stopped, before, begun, Untracked(recording, spec.settings))
        run = track(
            dataclasses.replace(recording, reference=None),  # the tracker never sees the truth
            spec,
            on_frame=course.note,
            cancelled=lambda: stopped() or course.done == wanted,
            on_first_pass=course.prepare,
            on_replay=course.replay,
            keeper=keeper,
            begun=begun,
        )
    return _job(run, course, clock(), wanted)


def _job(run: Run, course: _Course, seconds: float, wanted: int) -> TrackingJob:
    bridged = set(run.meta["bridged"])
    reasons = [(frame, reason) for frame, reason in course.reasons if frame not in bridged]
    blind = course.problems.stretches()
    meta = {
        **run.meta,
        "wall_seconds": seconds,
        INCOMPLETE: len(run.frame) < wanted,
        "blind": [dataclasses.asdict(stretch) for stretch in blind],
    }
    return TrackingJob(
        run=dataclasses.replace(run, meta=meta),
        wanted=wanted,
        gaps=gaps_of(reasons),
        blind=blind,
        stopped=len(run.frame) < wanted,
        untracked=course.untracked,
        changed=tuple(course.changed),
    )


class _Clock:
    """Seconds that were spent on a run, by earlier programs too."""

    def __init__(self, before: float) -> None:
        self._begun = time.perf_counter() - before

    def __call__(self) -> float:
        return time.perf_counter() - self._begun


@contextmanager
def _journal(part: Path | None, clock: _Clock, wish: Wish) -> Iterator[RunJournal | None]:
    if part is None:
        yield None
        return
    journal = RunJournal(part, clock, wish)
    try:
        yield journal
    finally:
        journal.close()


def _first_pass(settings: Settings, frames: range) -> int:
    """Frames that are tracked beforehand, to estimate lengths."""
    from stereotrack_core.tracking.pipeline import LENGTH_FRAMES

    return min(LENGTH_FRAMES, len(frames)) if settings.body.proportions == "sequence" else 0
