"""A stretch of a run tracked again around clicks: the tracker follows them, the rest stays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from stereotrack_core.recording.description import Recording
from stereotrack_core.tracking.clouds import Clouds
from stereotrack_core.tracking.frame import Run, TrackedFrame, assembled
from stereotrack_core.tracking.prepare import Start, continued, prepare, unprepared
from stereotrack_core.tracking.repair import REPAIRED, repaired
from stereotrack_core.tracking.repeating import RETRACKED
from stereotrack_core.tracking.run import advances
from stereotrack_core.tracking.run_spec import Hooks, RunSpec
from stereotrack_core.worker_processes import Asker


@dataclass(frozen=True, eq=False)
class Retrack:
    """Tracks a stretch again, as a task of a process; tells the number of every frame done."""

    recording: Recording  # with the subject that the run tracked, and no reference
    spec: RunSpec  # the run's, with the stretch as its frames and with the clicks
    learned: range  # frames from which the run learned its background
    start: Start | None  # the run's pose before the stretch, with its shape; None: found anew

    def __call__(self, asker: Asker) -> Retracked:
        """Do it in the process."""
        return self.tracked(lambda _frame: asker.on_frames(1), asker.cancelled)

    def tracked(
        self,
        on_frame: Callable[[int], None] = lambda _frame: None,
        cancelled: Callable[[], bool] = lambda: False,
    ) -> Retracked:
        """The stretch tracked with the clicks, and backwards from each; raises Cancelled."""
        hooks, found = Hooks.asking(cancelled), list[TrackedFrame]()
        with Clouds(self.recording, self.spec) as clouds:
            if self.start is None:
                run = prepare(clouds, hooks)
            else:
                clouds.learn(self.learned, hooks)
                run = continued(unprepared(clouds), self.start)
            for advance in advances(run, clouds.frames, hooks):
                run, found = advance.run, advance.gained.into(found)
                for frame in advance.gained.frames:
                    on_frame(frame.frame)
            frames, mended = repaired(run, found, cancelled)
            hooks.before_step()
            meta = run.origin().meta
        return Retracked(tuple(frames), tuple(mended), meta["clicks"])


@dataclass(frozen=True, eq=False)
class Retracked:
    """Frames of a stretch, and those of them that were followed backwards from a click."""

    frames: tuple[TrackedFrame, ...]
    mended: tuple[int, ...]
    clicks: dict[str, object] | None  # description of the clicks in the run's meta

    def into(self, run: Run, frames: Sequence[TrackedFrame]) -> Run:
        """A run, given all its frames in their order, with the stretch in the place of its own."""
        new = {one.frame: one for one in self.frames}
        stretches = [*run.meta.get(RETRACKED, ()), [min(new), max(new)]]
        before = [k for k in run.meta.get(REPAIRED, ()) if k not in new]
        meta = {
            **run.meta,
            "clicks": self.clicks,
            RETRACKED: stretches,
            REPAIRED: sorted({*before, *self.mended}),
        }
        merged = [new.get(one.frame, one) for one in frames]
        return assembled(merged, run.state_names, meta, run.keypoints)
