"""A stretch of a run tracked again around clicks: the tracker follows them, the rest stays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.parameters import BodyShape
from stereotrack_core.body.pose import Pose
from stereotrack_core.errors import Cancelled
from stereotrack_core.recording.description import Recording
from stereotrack_core.tracking.frame import Run, TrackedFrame, assembled, in_place
from stereotrack_core.tracking.pipeline import Pipeline
from stereotrack_core.tracking.repair import REPAIRED, repaired
from stereotrack_core.tracking.repeating import RETRACKED
from stereotrack_core.tracking.run_spec import RunSpec
from stereotrack_core.worker_processes import Asker


@dataclass(frozen=True, eq=False)
class Beginning:
    """Where a run was before the stretch."""

    pose: Pose
    P: FloatArray | None = None
    """Covariance of the pose's state; None where the pose is that of the first frame itself."""


@dataclass(frozen=True, eq=False)
class Retrack:
    """Tracks a stretch again, as a task of a process; tells the number of every frame done."""

    recording: Recording
    """With the subject that the run tracked, and no reference."""
    spec: RunSpec
    """The run's, with the stretch as its frames and with the clicks."""
    learned: range
    """Frames from which the run learned its background."""
    shape: BodyShape
    """Of the body that the run tracked."""
    beginning: Beginning | None
    """None: found anew, as where the run had nothing before."""

    def __call__(self, asker: Asker) -> Retracked:
        """Do it in the process."""
        return self.tracked(lambda _frame: asker.on_frames(1), asker.cancelled)

    def tracked(
        self,
        on_frame: Callable[[int], None] = lambda _frame: None,
        cancelled: Callable[[], bool] = lambda: False,
    ) -> Retracked:
        """The stretch tracked forwards with the clicks, and backwards from each of them.

        Raises
        ------
        Cancelled
        """

        def ask(*_: object) -> None:
            if cancelled():
                raise Cancelled

        found: list[TrackedFrame] = []
        with Pipeline(self.recording, self.spec) as pipeline:
            pipeline.on_preparing = pipeline.before_step = ask
            pipeline.corrects = True
            stretch = self.spec.frames_of(pipeline.reader.frame_count)
            if self.beginning is None:
                pipeline.prepare(stretch)
            else:
                pipeline.learn(self.learned)
                start = self.beginning
                pipeline.go_on_from(start.pose, stretch, P=start.P, shape=self.shape)
            for tracked in pipeline.frames(stretch):
                in_place(found, tracked.without_cloud())
                on_frame(tracked.frame)
            frames, mended = repaired(pipeline, found, cancelled)
            ask()
            meta = pipeline.origin().meta()
        return Retracked(tuple(frames), tuple(mended), meta["clicks"])


@dataclass(frozen=True, eq=False)
class Retracked:
    """Frames of a stretch, and those of them that were followed backwards from a click."""

    frames: tuple[TrackedFrame, ...]
    mended: tuple[int, ...]
    clicks: dict[str, object] | None
    """What the run says of the clicks."""

    def into(self, run: Run, frames: Sequence[TrackedFrame]) -> Run:
        """A run with the stretch in the place of its own frames.

        Parameters
        ----------
        frames : sequence of TrackedFrame
            All of the run, in their order.
        """
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
