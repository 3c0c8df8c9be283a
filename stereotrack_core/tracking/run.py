"""A recording tracked from its first frame to its last."""

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, replace

from stereotrack_core.errors import Cancelled
from stereotrack_core.recording.description import Recording
from stereotrack_core.tracking.clouds import Clouds
from stereotrack_core.tracking.frame import Replaced, Run, TrackedFrame, run_of, seen_by_frame
from stereotrack_core.tracking.prepare import prepare, turned_round
from stereotrack_core.tracking.repair import REPAIRED, repaired
from stereotrack_core.tracking.run_checks import WARNINGS, run_warnings
from stereotrack_core.tracking.run_spec import Hooks, RunSpec
from stereotrack_core.tracking.second_look import looked_again
from stereotrack_core.tracking.smoothing import smoothed
from stereotrack_core.tracking.step import PersonModel, PersonState
from stereotrack_core.tracking.stored import body_of_run, subject_of_meta
from stereotrack_core.tracking.tracking import Tracking, stepped
from stereotrack_core.tracking.unfinished import UnfinishedRun


@dataclass(frozen=True, eq=False)
class Advance:
    """Progress of a run: a new frame, or a stretch that replaces earlier frames."""

    run: Tracking  # after it
    gained: Replaced


def advances(
    run: Tracking, frames: range, hooks: Hooks | None = None
) -> Generator[Advance, None, None]:
    """Track frames in their order; while one is worked on, the next clouds are made.

    If frames show that the person has faced the other way, all from the first with somebody are
    tracked anew, once. After a stretch with doubtful arms a second look replaces it.
    """
    hooks, rest = hooks or Hooks(), frames
    while True:
        if run.faced_away:
            run = turned_round(run, hooks)
            assert run.heading is not None  # noqa: S101
            assert run.heading.first is not None  # noqa: S101
            rest = range(run.heading.first.frame, frames.stop)
            yield Advance(run, Replaced(rest.start, ()))
        elif run.look.due or (not rest and run.look.pending):
            model, state = run.model, run.state
            assert isinstance(model, PersonModel)  # noqa: S101 - no other's frames are held
            assert isinstance(state, PersonState)  # noqa: S101
            state, look, frames_again = looked_again(
                run.look, model, state, run.clouds.ahead, hooks
            )
            run = replace(run, state=state, look=look)
            yield Advance(run, Replaced(frames_again[0].frame, frames_again))
        if not rest:
            return
        with run.clouds.ahead(rest) as clouds:
            for cloud, read in clouds:
                run, frame = stepped(run, cloud, read, hooks)
                yield Advance(run, Replaced(frame.frame, (frame,)))
                rest = rest[1:]
                if run.faced_away or run.look.due:
                    break


def track(
    recording: Recording,
    spec: RunSpec,
    *,
    on_advance: Callable[[Advance], None] = lambda _: None,
    hooks: Hooks | None = None,
    begun: UnfinishedRun | None = None,
    count: int | None = None,
) -> Run:
    """Track a recording; a run that is cancelled keeps the frames it has.

    Parameters
    ----------
    on_advance : callable
        Called after every frame, and where frames are replaced.
    begun : UnfinishedRun, optional
        To go on with, to the last bit as if it had never been stopped.
    count : int, optional
        Number of frames after which tracking ends.

    Raises
    ------
    Cancelled
        If a hook raises it before the first frame is done.
    InputError
        If a view is unknown or no view gives depth.

    Examples
    --------
    >>> spec = RunSpec(preset("accurate"), frames=range(40))
    >>> run = track(open_recording(Path("recording")), spec)
    >>> run.trajectory().points.shape  # frames, nine landmarks, x y z in metres
    (40, 9, 3)
    """
    found, hooks = list[TrackedFrame](), hooks or Hooks()
    if begun is not None:
        found = list(begun.done)
        recording = replace(recording, subject=subject_of_meta(begun.meta))
        spec = replace(spec, seen=seen_by_frame(begun.frames))
    with Clouds(recording, spec) as clouds:
        run = prepare(clouds, hooks, begun)
        frames = clouds.frames if begun is None else begun.rest_of(clouds.frames)
        newest = found[-1].frame if found else -1
        most = None if count == len(clouds.frames) else count
        try:
            for advance in () if len(found) == most else advances(run, frames, hooks):
                run, found = advance.run, advance.gained.into(found)
                on_advance(advance)
                caught_up = bool(found) and found[-1].frame >= newest
                newest = found[-1].frame if caught_up else newest
                if caught_up and (len(found) == most or hooks.cancelled()):
                    break
        except Cancelled:  # in a second look
            if not found:
                raise
        found, mended = repaired(run, found, hooks.cancelled)
        done = finished(run, found)
        warnings = run_warnings(found, body_of_run(done), recording, spec)
        done = done.stating(**{REPAIRED: mended}) if mended else done
        return done.stating(**{WARNINGS: list(warnings)})


def finished(run: Tracking, frames: Sequence[TrackedFrame]) -> Run:
    """Put successive frames together to a run, smoothed if that was asked for."""
    if not run.clouds.spec.smooth:
        return run_of(frames, run.origin())
    back = smoothed(frames, run.model.setup, fit_movement=not run.clouds.have_depth)
    bridged = [b.frame for a, b in zip(frames, back, strict=True) if b.tracked and not a.tracked]
    return run_of(back, run.origin()).stating(smoothed=True, bridged=bridged)
