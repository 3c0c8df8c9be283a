"""All that has to be known before the first frame: background, lengths, shape and first pose."""

import dataclasses
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import partial

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import body_of_subject, landmarks
from stereotrack_core.body.parameters import BodyShape
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.proportions import Proportions, measured
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.tracking.clouds import Clouds, CloudSource, chain_of
from stereotrack_core.tracking.frame import TrackedFrame
from stereotrack_core.tracking.initialise.first_pose import first_clouds, shape_in
from stereotrack_core.tracking.initialise.heading import HeadingWatch
from stereotrack_core.tracking.lengths_fit import (
    ESTIMATED,
    ESTIMATING_LENGTHS,
    LENGTH_FRAMES,
    WellSeenFrames,
    lengths_by_height,
    lengths_of_standing,
    subject_with,
)
from stereotrack_core.tracking.model import step
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.residuals.silhouette import edge_maps
from stereotrack_core.tracking.run_spec import Hooks, RunSpec, given_heading, is_found
from stereotrack_core.tracking.saved_state import check_like, has_state, restored
from stereotrack_core.tracking.second_look import LookNumbers, SecondLook
from stereotrack_core.tracking.shape_fit import fitted_offsets, fitted_outline
from stereotrack_core.tracking.smoothing import smoothed
from stereotrack_core.tracking.stored import began_of
from stereotrack_core.tracking.tracking import (
    HEADING,
    LOOK,
    TRACK,
    Tracking,
    first_pose,
    initialiser_of,
    looked_for,
    model_of,
    stepped,
)
from stereotrack_core.tracking.unfinished import Checkpoint, UnfinishedRun


@dataclass(frozen=True, eq=False)
class Start:
    """Where another run was, from which tracking goes on."""

    pose: Pose
    P: FloatArray | None = None  # (n, n), used if the model has the same state
    shape: BodyShape | None = None  # shape of the body; None: as the settings have it
    look: SecondLook | None = None  # second look of the other run, up to the frame of the pose


def prepare(
    clouds: Clouds, hooks: Hooks | None = None, begun: UnfinishedRun | None = None
) -> Tracking:
    """Learn the background, estimate lengths and shape, find the first pose, as the settings ask.

    A run that was `begun` and stopped goes on to the last bit as if it had not been stopped.
    """
    hooks, run = hooks or Hooks(), unprepared(clouds)
    clouds.learn(clouds.frames, hooks)
    checkpoint = None if begun is None else begun.checkpoint
    if checkpoint is None or not checkpoint.started:
        if clouds.have_depth:
            run = _ready(run, clouds.frames, hooks)
        else:  # the first frames are tracked in advance
            run, pose = _with_first_frames(run, clouds.frames, hooks)
            if pose is not None and not isinstance(run.init, Pose):
                run = run.from_pose(clouds.frames.start, pose)
    if begun is None:
        return run
    made, began = str(begun.meta.get("made", run.made)), run.began or began_of(begun.meta)
    run = dataclasses.replace(run, made=made, began=began, resumed_at=begun.resumed_at)
    return run if checkpoint is None else _restored(run, checkpoint, begun, hooks)


def _restored(
    run: Tracking, checkpoint: Checkpoint, begun: UnfinishedRun, hooks: Hooks
) -> Tracking:
    """The run after the frames that are done; a learning background sees them again."""
    clouds, frames, arrays = run.clouds, run.clouds.frames, checkpoint.arrays
    if checkpoint.started:
        run = run.of_body(body_of_subject(run.recording.subject, begun.shape))
    state, look, heading = run.state, run.look, run.heading
    check_like(state, arrays, TRACK)
    state = restored(type(state), arrays, TRACK)
    if has_state(arrays, LOOK):  # older versions had none
        look = look.restored(restored(LookNumbers, arrays, LOOK), begun.done)
    if heading is not None:
        known = has_state(arrays, HEADING)
        watched_no_more = dataclasses.replace(heading, active=False)
        heading = restored(HeadingWatch, arrays, HEADING) if known else watched_no_more
    done = frames[: frames.index(checkpoint.frame) + 1]
    for place, frame in enumerate(done):
        if not clouds.drop(frame) and clouds.chain.learns:
            clouds.take(frame)
        hooks.on_preparing("going on after the frames that are done", place, len(done))
    started = checkpoint.started
    return dataclasses.replace(run, started=started, state=state, look=look, heading=heading)


def unprepared(clouds: Clouds) -> Tracking:
    """A run of which nothing is known but its settings."""
    settings, spec, recording = clouds.settings, clouds.spec, clouds.recording
    watched = is_found(spec.init) and given_heading(spec.init) is None and settings.follows_data
    model = model_of(clouds, recording, body_of_subject(recording.subject, settings.body))
    # One view hides arms in all tries alike; a learning background does not give the same clouds.
    may_look_again = len(clouds.chain.view_names) > 1 and not clouds.chain.learns
    return Tracking(
        clouds=clouds,
        recording=recording,
        model=model,
        state=model.absent(),
        init=spec.init,
        heading=HeadingWatch(recording.fps) if watched and clouds.have_depth else None,
        look=SecondLook(settings.tracking.second_look if may_look_again else 0),
        made=datetime.now(UTC).isoformat(timespec="milliseconds"),
    )


def continued(run: Tracking, start: Start) -> Tracking:
    """The run from another run's pose on; nothing is looked for."""
    run.clouds.forget()
    run = run.of_body(run.body if start.shape is None else run.body.with_shape(start.shape))
    state, look = run.model.first(start.pose, P=start.P), run.look
    P = start.P
    if start.look is not None and P is not None and P.shape == state.P.shape:
        look = dataclasses.replace(start.look, tries=look.tries)
    return dataclasses.replace(
        run,
        state=state,
        started=True,
        init=start.pose,
        given="the pose of another run",
        heading=None,
        look=look,
    )


def turned_round(run: Tracking, hooks: Hooks) -> Tracking:
    """The run before its first pose, which is turned round."""
    assert run.heading is not None  # noqa: S101 - else nothing has shown that it faces away
    heading, clouds = run.heading.turned_round(), run.clouds
    assert heading.first is not None  # noqa: S101
    clouds.forget()
    run = dataclasses.replace(
        run,
        heading=heading,
        found=heading.first.pose,
        started=False,
        look=SecondLook(run.look.tries),
        resumed_at=(),
    )
    if clouds.chain.learns:
        clouds.learn(clouds.frames, hooks)
    run = run.of_body(body_of_subject(run.recording.subject, clouds.settings.body))
    if clouds.settings.tracking.fit_shape:
        run = with_fitted_shape(run, clouds.frames, hooks)
    clouds.forget(before=heading.first.frame)
    return run


def estimates_lengths(run: Tracking) -> bool:
    """Whether lengths come from the first frames: as wanted, or as the subject has none."""
    known = measured(run.recording.subject)
    wanted = run.clouds.settings.body.proportions
    return wanted in ("sequence", "" if known else "individual")


def with_estimated_lengths(run: Tracking, frames: range, hooks: Hooks) -> Tracking:
    """The run of a body with lengths from the first frames, if they come from there."""
    settings = run.clouds.settings
    if settings.body.proportions == "sequence":
        return with_lengths(run, _tracked_lengths(run, frames, hooks))
    if estimates_lengths(run):
        clouds = _first_clouds(run, frames, hooks)
        found = lengths_of_standing(clouds, settings.depth.upright)
        if found is not None:
            return with_lengths(run, found, f"average, {found.height:.2f} m tall")
    return run


def with_lengths(run: Tracking, lengths: Proportions, name: str = ESTIMATED) -> Tracking:
    """The run of a body with these lengths, of a subject of this name."""
    subject = subject_with(lengths, run.recording.subject, name)
    run = dataclasses.replace(run, recording=dataclasses.replace(run.recording, subject=subject))
    return run.of_body(body_of_subject(subject, run.clouds.settings.body))


def with_fitted_shape(run: Tracking, frames: range, hooks: Hooks) -> Tracking:
    """The run of a body whose shape is fitted to the first frames that show somebody."""
    if not run.clouds.have_depth:
        return _with_first_frames(run, frames, hooks)[0]
    clouds, pose = _first_clouds(run, frames, hooks), partial(first_pose, run, hooks=hooks)
    found = shape_in(initialiser_of(run), clouds, pose, hooks)
    return run if found is None else run.of_body(run.body.with_shape(found))


def _ready(run: Tracking, frames: range, hooks: Hooks) -> Tracking:
    run = with_estimated_lengths(run, frames, hooks)
    if is_found(run.init):
        clouds = _first_clouds(run, frames, hooks)
        found = looked_for(run, clouds, hooks) if clouds else None
        run = dataclasses.replace(run, found=found)
    settings = run.clouds.settings
    if settings.tracking.fit_shape and settings.follows_data:
        run = with_fitted_shape(run, frames, hooks)
    return run


_FIRST_FRAMES = 60  # frames that are tracked in advance
_ASKED = 24  # frames, evenly spread over these, that the shape is fitted to
_FEWEST = 6  # tracked frames without which nothing is fitted


def _with_first_frames(run: Tracking, frames: range, hooks: Hooks) -> tuple[Tracking, Pose | None]:
    """Track the first frames, smooth them, and compare contours and keypoints with the body's.

    Gives the run of a body whose shape has margins as the contours and offsets as the keypoints
    show them, and the pose of the first frame. The shape is the body's own, and there is no pose,
    where hardly any frame is tracked.
    """
    clouds, model, state = list[Cloud](), run.model, run.state
    for done, frame in enumerate(frames[:_FIRST_FRAMES]):
        hooks.on_preparing("measuring the first frames", done, _FIRST_FRAMES)
        clouds.append(run.clouds.keep(frame))
    body, tracked = run.body, list[TrackedFrame]()
    for done, cloud in enumerate(clouds):
        hooks.on_preparing("tracking the first frames", done, len(clouds))
        hooks.before_step()
        state, estimate = step(model, state, cloud)
        places = landmarks(body, estimate.pose)
        tracked.append(TrackedFrame(cloud.frame, estimate, places, cloud, {}).without_cloud())
    tracked = smoothed(tracked, model.setup, fit_movement=True)
    known = [i for i, one in enumerate(tracked) if one.tracked]
    shape = body.shape
    if len(known) < _FEWEST:
        return run.of_body(body.with_shape(shape)), None
    if model.setup.parameters.fit_shape:
        chosen = np.unique(np.linspace(0, len(known) - 1, _ASKED).astype(int))
        asked = [(tracked[known[i]].estimate.pose, clouds[known[i]]) for i in chosen]
        edges = [(pose, edge_maps(cloud)) for pose, cloud in asked]
        shape = fitted_outline(body, edges)
        if any(own for _, own in edges):  # else offsets look like other lengths of the body
            setup = dataclasses.replace(model.setup, body=body.with_shape(shape))
            shape = fitted_offsets(setup, asked)
    return run.of_body(body.with_shape(shape)), tracked[0].pose


def _first_clouds(run: Tracking, frames: range, hooks: Hooks) -> Sequence[Cloud]:
    """The first clouds that show somebody; all that are made on the way are kept."""
    told = partial(hooks.on_preparing, "measuring the first frames")
    least = run.clouds.settings.tracking.least_points
    return first_clouds(run.clouds.keep, frames, least, told)


def _tracked_lengths(run: Tracking, frames: range, hooks: Hooks) -> Proportions:
    """Track the first part once with lengths after the height, and estimate them from it."""
    settings, spec, wanted = run.clouds.settings, run.clouds.spec, frames[:LENGTH_FRAMES]
    expected = lengths_by_height(_first_clouds(run, frames, hooks), settings.depth.upright)
    if not settings.follows_data:
        settings = dataclasses.replace(settings, tracking=TrackingParameters())
    settings = settings.replaced(proportions="individual")
    subject, views = subject_with(expected, None), run.clouds.views
    recording = dataclasses.replace(run.recording, subject=subject)
    first_spec = RunSpec(settings, frames=wanted, views=views, seed=spec.seed, init=run.init)
    own = CloudSource(*chain_of(recording, first_spec, views, run.clouds.reader))
    with closing(own.chain), Clouds(recording, first_spec, own) as clouds:
        first, seen = prepare(clouds, hooks), WellSeenFrames()
        first = dataclasses.replace(first, heading=None, look=SecondLook(0))
        with clouds.ahead(wanted) as made:
            for done, (cloud, read) in enumerate(made):
                first, frame = stepped(first, cloud, read, hooks)
                seen.add(frame)
                hooks.on_preparing(ESTIMATING_LENGTHS, done, len(wanted))
        return seen.lengths(expected, first.model.setup)
