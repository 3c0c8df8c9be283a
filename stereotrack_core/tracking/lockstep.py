"""Runs over the same frames of a recording, side by side: each cloud is made once for all."""

from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field

from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.selection import tracked_views
from stereotrack_core.tracking.clouds import Clouds, SharedClouds, chain_of
from stereotrack_core.tracking.frame import Run, TrackedFrame
from stereotrack_core.tracking.prepare import prepare
from stereotrack_core.tracking.run import Advance, advances, finished
from stereotrack_core.tracking.run_spec import RunSpec
from stereotrack_core.tracking.second_look import SECOND_LOOK
from stereotrack_core.tracking.tracking import Tracking


@dataclass(eq=False)
class LockstepRun:
    """A run, frame by frame, until an `error`."""

    recording: Recording
    spec: RunSpec
    frames: range
    clouds: SharedClouds
    error: Exception | None = None
    seconds: float = 0.0  # that it would have taken alone
    _found: list[TrackedFrame] = field(default_factory=list)
    _done: int = 0
    _open: Clouds | None = None
    _run: Tracking | None = None
    _going: Iterator[Advance] = field(default_factory=lambda: iter(()))

    def step(self) -> None:
        """Track the next frame."""
        if self._run is None:
            self._open = Clouds(self.recording, self.spec, self.clouds)
            self._run = prepare(self._open)
            self._going = advances(self._run, self.frames)
        wanted = self.frames[self._done]
        while True:  # frames that are replaced are caught up with at once
            run = self._take(next(self._going))
            if self._found and self._found[-1].frame == wanted and not run.faced_away:
                break
        self._done += 1

    def run(self) -> Run:
        """All frames so far as one run."""
        for advance in self._going:  # a second look at the last frames
            self._take(advance)
        assert self._run is not None  # noqa: S101 - there is at least one frame
        return finished(self._run, self._found)

    def close(self) -> None:
        """Take no more clouds."""
        if self._open is not None:
            self._open.close()

    def _take(self, advance: Advance) -> Tracking:
        self._run, self._found = advance.run, advance.gained.into(self._found)
        for frame in advance.gained.frames:  # a view's depth is part of "views"
            made = sum(frame.cloud.seconds.get(stage, 0.0) for stage in ("views", "outliers"))
            found = sum(frame.estimate.seconds.values())
            once = frame.seconds.get("read", 0.0) + made + found
            self.seconds += frame.seconds.get(SECOND_LOOK, once)
        return advance.run


def track_together(
    recording: Recording,
    specs: Sequence[RunSpec],
    *,
    on_frames: Callable[[int], None] = lambda _: None,
) -> Generator[LockstepRun, None, None]:
    """Make all runs, frame by frame; then give one after the other.

    `specs` agree in depth parameters, colour, views and frames; the recording is without its
    reference. An error of one run ends no other and is told by the run. `on_frames` is told how
    many frames more were tracked, over all runs, and may raise Cancelled.
    """
    with ExitStack() as stack:
        views = tracked_views(recording, specs[0].views, specs[0].keypoints)
        chain, reader = chain_of(recording, specs[0], views)
        stack.enter_context(reader)
        stack.callback(chain.close)
        clouds = SharedClouds(chain, reader)
        frames = specs[0].frames_of(clouds.reader.frame_count)
        runs = [LockstepRun(recording, spec, frames, clouds) for spec in specs]
        for run in runs:
            stack.callback(run.close)
        for _ in frames:
            for run in runs:
                if run.error is not None:
                    continue
                try:
                    run.step()
                except Exception as error:  # noqa: BLE001 - told by the run
                    run.error = error
                    run.close()
                on_frames(1)
        yield from runs
