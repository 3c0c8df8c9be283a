"""Runs over the same frames of a recording, side by side: each cloud is made once for all."""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass, field
from typing import Any

from stereotrack_core.body.pose import Pose
from stereotrack_core.errors import Cancelled
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.selection import tracked_views
from stereotrack_core.tracking.frame import Run, TrackedFrame, assembled, in_place
from stereotrack_core.tracking.pipeline import Pipeline
from stereotrack_core.tracking.run_spec import RunSpec
from stereotrack_core.tracking.second_look import SECOND_LOOK
from stereotrack_core.tracking.shared_clouds import CloudTaker, SharedClouds, chain_of


@dataclass(frozen=True, eq=False)
class RunInput:
    """A run that shall be made together with others."""

    recording: Recording
    """As its tracker may know it: without the reference."""
    spec: RunSpec
    starts: Mapping[int, Pose] = field(default_factory=dict)
    """By frame: where the tracker is put on which pose before it sees a frame.
    This is for judging alone: such a run knows the truth."""


class LockstepRun:
    """A run that goes forward frame by frame.

    Attributes
    ----------
    error : Exception or None
        What has ended it.
    seconds : float
        That it would have taken alone, from images to poses.
    """

    def __init__(self, given: RunInput, frames: range, clouds: CloudTaker) -> None:
        self._given = given
        self._frames = frames
        self._clouds = clouds
        self._found: list[TrackedFrame] = []
        self._done = 0
        self._pipeline: Pipeline | None = None
        self._going: Generator[TrackedFrame, None, None] | None = None
        self.error: Exception | None = None
        self.seconds = 0.0

    def step(self) -> None:
        """Track the next frame."""
        if self._pipeline is None or self._going is None:
            self._pipeline = Pipeline(self._given.recording, self._given.spec, clouds=self._clouds)
            self._pipeline.corrects = not self._given.starts
            self._pipeline.prepare(self._frames)
            self._going = self._stretches(self._pipeline)
        wanted = self._frames[self._done]
        while True:  # frames that come again are caught up with at once
            tracked = next(self._going)
            self.seconds += _seconds_of(tracked)
            in_place(self._found, tracked.without_cloud())
            if tracked.frame == wanted and not self._pipeline.begins_again:
                break
        self._done += 1

    def run(self) -> Run:
        """All frames so far as one run."""
        assert self._pipeline is not None  # noqa: S101 - there is at least one frame
        for tracked in self._going or ():  # frames that come again after the last one
            self.seconds += _seconds_of(tracked)
            in_place(self._found, tracked.without_cloud())
        if self._given.spec.smooth:
            return self._pipeline.smoothed_run(self._found)
        names, meta = self._pipeline.tracker.state_names, self._pipeline.origin().meta()
        return assembled(self._found, names, meta, self._given.spec.used_keypoints)

    def close(self) -> None:
        """Take no more clouds."""
        if self._going is not None:
            self._going.close()
        if self._pipeline is not None:
            self._pipeline.close()
        self._clouds.leave()

    def _stretches(self, pipeline: Pipeline) -> Generator[TrackedFrame, None, None]:
        """All frames; the tracker is put on the poses that are given before it sees theirs."""
        starts = self._given.starts
        begins = sorted(frame for frame in starts if frame in self._frames)
        if not begins or begins[0] != self._frames.start:
            begins.insert(0, self._frames.start)
        for begin, end in zip(begins, [*begins[1:], self._frames.stop], strict=True):
            if begin in starts:
                pipeline.tracker.start(starts[begin])
            with closing(pipeline.frames(range(begin, end))) as tracked:
                yield from tracked


def track_together(
    inputs: Sequence[RunInput],
    *,
    on_frames: Callable[[int], None] = lambda _: None,
    cancelled: Callable[[], bool] = lambda: False,
    go_on_after_errors: bool = False,
) -> Generator[LockstepRun, None, None]:
    """Make all runs, frame by frame; then give one after the other.

    Parameters
    ----------
    inputs : sequence of RunInput
        They agree in all that clouds depend on; see :func:`cloud_key`.
    on_frames : callable, optional
        Told how many frames more were tracked, over all runs.
    go_on_after_errors : bool
        Whether an error of one run ends nothing else; it is then told by the run.
    """
    with ExitStack() as stack:
        clouds = _clouds_for(inputs[0], stack)
        frames = inputs[0].spec.frames_of(clouds.reader.frame_count)
        runs = [LockstepRun(one, frames, clouds.taker()) for one in inputs]
        for run in runs:
            stack.callback(run.close)
        for _ in frames:
            for run in runs:
                if run.error is not None:
                    continue
                try:
                    run.step()
                except Exception as error:  # told by the run, where others go on
                    if not go_on_after_errors:
                        raise
                    run.error = error
                    run.close()
                on_frames(1)
                if cancelled():
                    raise Cancelled
        yield from runs


def cloud_key(spec: RunSpec) -> tuple[Any, ...]:
    """All that the clouds of a recording depend on."""
    views = None if spec.views is None else tuple(spec.views)
    return spec.settings.depth, spec.settings.tracking.wants_colour, views, spec.frames


def _clouds_for(given: RunInput, stack: ExitStack) -> SharedClouds:
    views = tracked_views(given.recording, given.spec.views, given.spec.keypoints)
    chain, reader = chain_of(given.recording, given.spec, views)
    stack.enter_context(reader)
    stack.callback(chain.close)
    return SharedClouds(chain, reader)


def _seconds_of(tracked: TrackedFrame) -> float:
    """What a frame took from its images to its pose; the parts of a view's depth are in "views"."""
    again = tracked.seconds.get(SECOND_LOOK)
    if again is not None:
        return again
    made = sum(tracked.cloud.seconds.get(stage, 0.0) for stage in ("views", "outliers"))
    return tracked.seconds.get("read", 0.0) + made + sum(tracked.estimate.seconds.values())
