"""A recording tracked from its first frame to its last."""

from __future__ import annotations

from collections.abc import Callable

from stereotrack_core.errors import Cancelled
from stereotrack_core.recording.description import Recording
from stereotrack_core.tracking.frame import Run, TrackedFrame, in_place, run_of
from stereotrack_core.tracking.pipeline import Pipeline
from stereotrack_core.tracking.repair import repaired, with_repaired
from stereotrack_core.tracking.run_checks import run_warnings, with_warnings
from stereotrack_core.tracking.run_spec import RunSpec
from stereotrack_core.tracking.stored import body_of_run
from stereotrack_core.tracking.unfinished import RunKeeper, UnfinishedRun


def track(
    recording: Recording,
    spec: RunSpec,
    *,
    on_frame: Callable[[TrackedFrame], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
    on_preparing: Callable[[str, int, int], None] | None = None,
    keeper: RunKeeper | None = None,
    begun: UnfinishedRun | None = None,
    count: int | None = None,
) -> Run:
    """Track a recording; a run that is cancelled keeps the frames it has.

    Parameters
    ----------
    on_frame : callable, optional
        Called after every frame; frames may come again, see :meth:`Pipeline.frames`.
    cancelled : callable, optional
        Asked after every frame whether to stop.
    on_preparing : callable, optional
        Told, in any thread, which stage before the first frame is under way and how many of its
        parts of how many are done; may raise :class:`Cancelled`.
    keeper, begun
        See :class:`Pipeline`.
    count : int, optional
        Tracking ends after so many of the frames, as when a run that was stopped is repeated.

    Raises
    ------
    Cancelled
        Where `on_preparing` raises it before the first frame is done.

    Examples
    --------
    >>> spec = RunSpec(preset("accurate"), frames=range(40))
    >>> run = track(open_recording(Path("recording")), spec)
    >>> run.trajectory().points.shape  # frames, nine landmarks, x y z in metres
    (40, 9, 3)
    """
    found: list[TrackedFrame] = [] if begun is None else list(begun.done)
    with Pipeline(recording, spec, keeper=keeper, begun=begun) as pipeline:
        pipeline.on_preparing = on_preparing or pipeline.on_preparing
        pipeline.corrects = True
        wanted = spec.frames_of(pipeline.reader.frame_count)
        pipeline.prepare(wanted)
        most = None if count == len(wanted) else count
        newest = found[-1].frame if found else -1
        try:
            for tracked in () if len(found) == most else pipeline.frames(wanted):
                in_place(found, tracked.without_cloud())
                if on_frame is not None:
                    on_frame(tracked)
                again, newest = tracked.frame < newest, max(newest, tracked.frame)
                if not again and (len(found) == most or (cancelled is not None and cancelled())):
                    break
        except Cancelled:  # in a second look
            if not found:
                raise
        found, mended = repaired(pipeline, found, cancelled)
        run = pipeline.smoothed_run(found) if spec.smooth else run_of(found, pipeline.origin())
        warnings = run_warnings(found, body_of_run(run), recording, spec)
        return with_warnings(with_repaired(run, mended), warnings)
