"""A run under way as a value, and its step from one frame to the next."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from stereotrack_core.body.model import BodyModel, landmarks
from stereotrack_core.body.pose import Pose
from stereotrack_core.depth.cloud import FRAMES_APART, Cloud, contradicted_share
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.folder import fingerprint
from stereotrack_core.tracking.clouds import Clouds
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.frame import FirstFrame, Origin, TrackedFrame
from stereotrack_core.tracking.initialise.first_pose import (
    facing,
    first_pose_from_images,
    first_pose_in,
    search_chain,
)
from stereotrack_core.tracking.initialise.heading_watch import HeadingWatch
from stereotrack_core.tracking.initialise.seeds import t_pose_in_cloud
from stereotrack_core.tracking.model import (
    TrackModel,
    TrackState,
    cameras_of,
    initialiser_for,
    model_for,
    step,
)
from stereotrack_core.tracking.run_spec import FirstPose, Hooks, given_heading, is_found
from stereotrack_core.tracking.saved_state import Arrays, saved
from stereotrack_core.tracking.second_look import SecondLook, is_sure
from stereotrack_core.tracking.step import PersonModel

TRACK, LOOK, HEADING = "track", "look", "heading"  # names under which states are saved begin so


@dataclass(frozen=True, eq=False)
class Tracking:
    """A run under way: what is tracked, and everything that its next frame depends on."""

    clouds: Clouds
    recording: Recording  # with the subject that is tracked, whose lengths may have been estimated
    model: TrackModel
    state: TrackState
    init: FirstPose  # first pose, or how it is found
    started: bool = False  # whether the model was given a first pose, of somebody there
    found: Pose | None = None  # first pose that was found in advance
    began: FirstFrame | None = None
    heading: HeadingWatch | None = None  # None if the heading is given, or not looked for
    look: SecondLook = dataclasses.field(default_factory=lambda: SecondLook(0))
    given: str = "pose"  # source of a first pose that is given, in words
    made: str = ""  # when tracking began, ISO 8601, UTC
    resumed_at: tuple[int, ...] = ()  # frames with which tracking went on after it had been stopped

    @property
    def body(self) -> BodyModel:
        """Body that is tracked."""
        return self.model.setup.body

    @property
    def found_so_far(self) -> tuple[bool, str, int]:
        """Signs that the origin says more: the beginning, the heading, and second looks."""
        heading = "" if self.heading is None else self.heading.state
        return self.started, heading, len(self.look.changed)

    @property
    def faced_away(self) -> bool:
        """Whether the frames so far show that the person faces the other way."""
        return self.heading is not None and self.heading.faced_away

    def of_body(self, body: BodyModel) -> Tracking:
        """The run of another body, before its first frame."""
        model = model_of(self.clouds, self.recording, body)
        return dataclasses.replace(self, model=model, state=model.absent())

    def from_pose(self, frame: int, pose: Pose) -> Tracking:
        """The run before the first frame that shows somebody, in a pose."""
        first, heading = FirstFrame(frame, pose), self.heading
        heading = None if heading is None else dataclasses.replace(heading, first=first)
        state = self.model.first(pose)
        return dataclasses.replace(self, state=state, started=True, began=first, heading=heading)

    def origin(self) -> Origin:
        """Describe where the frames come from."""
        clouds, spec = self.clouds, self.clouds.spec
        found, asked = clouds.chain.parameters.values(), spec.settings.depth.values()
        colour = clouds.reader.colour
        used = dataclasses.replace(
            spec, views=clouds.views, frames=clouds.frames, init=self.init, colour=colour
        )
        return Origin(
            recording=self.recording,
            fingerprint=fingerprint(self.recording),
            spec=used,
            detections=clouds.detections,
            state_names=self.model.state_names,
            shape=self.body.shape,
            given=self.given,
            began=self.began,
            made=self.made,
            resumed_at=self.resumed_at,
            heading=None if self.heading is None else self.heading.to_dict(),
            detector="" if clouds.detector is None else clouds.detector.name,
            detected_scenes=clouds.chain.silhouettes.made,
            looked_again=self.look.changed,
            from_recording=dict(found.items() - asked.items()),
        )

    def saved(self) -> Arrays:
        """Arrays from which the run goes on if it is stopped."""
        look = saved(self.look.numbers(), LOOK)
        return {**saved(self.state, TRACK), **look, **saved(self.heading, HEADING)}


def model_of(clouds: Clouds, recording: Recording, body: BodyModel) -> TrackModel:
    """Model of a body as the settings and the pose detector have it."""
    body = body if clouds.detector is None else clouds.detector.body(body)
    cameras = cameras_of(recording, clouds.views)
    given = body, clouds.settings, cameras, recording.fps, clouds.spec.seed
    return model_for(*given, clouds=clouds.have_depth)


def stepped(
    run: Tracking, cloud: Cloud, read: float, hooks: Hooks
) -> tuple[Tracking, TrackedFrame]:
    """Track the next frame; `read`: seconds that reading its images took."""
    clouds = run.clouds
    hooks.before_step()
    if len(clouds.detections):
        cloud = dataclasses.replace(cloud, detections=clouds.detections.until(cloud.frame))
    run = _started(run, cloud, hooks)
    state, estimate = step(run.model, run.state, cloud)
    run = _with_heading(dataclasses.replace(run, state=state), cloud, estimate)
    found = np.where(estimate.tracked, landmarks(run.body, estimate.pose), np.nan)
    seconds = {"read": read, **cloud.seconds, **estimate.seconds}
    asked = (cloud.frame - clouds.frames.start) % FRAMES_APART == 0
    contradicted = contradicted_share(cloud) if asked else np.nan
    seen = None if clouds.detector is None else clouds.detector.seen(cloud.frame)
    frame = TrackedFrame(cloud.frame, estimate, found, cloud, seconds, contradicted, seen)
    look = run.look.with_frame(frame, sure=is_sure(run.model, state))
    return dataclasses.replace(run, look=look), frame


def first_pose(run: Tracking, cloud: Cloud, hooks: Hooks) -> Pose:
    """Pose with which the track begins in the first cloud that shows somebody."""
    if isinstance(run.init, Pose):
        return run.init
    found = None
    if is_found(run.init):
        found = run.found or looked_for(run, [cloud], hooks)
    return found or t_pose_in_cloud(run.body, cloud.points, run.clouds.settings.depth.upright)


def looked_for(run: Tracking, clouds: Sequence[Cloud], hooks: Hooks) -> Pose | None:
    """First pose of whoever successive clouds show; None where nobody is tracked."""
    settings, reader = run.clouds.settings, run.clouds.reader
    told = partial(hooks.on_preparing, "finding the initial pose")
    model = initialiser_of(run)
    if settings.follows_data:
        found = first_pose_in(model, clouds, told)
    else:
        chain = search_chain(reader, settings.depth, run.clouds.views)
        frames = [cloud.frame for cloud in clouds]
        found = first_pose_from_images(model, chain, reader, frames, run.clouds.frames, told)
    heading, upright = given_heading(run.init), settings.depth.upright
    return None if found is None else facing(found, heading, upright)


def initialiser_of(run: Tracking) -> PersonModel:
    """Model that looks for the person's first pose."""
    clouds, cameras = run.clouds, cameras_of(run.recording, run.clouds.views)
    return initialiser_for(run.body, clouds.settings, cameras, run.recording, clouds.spec.seed)


def _started(run: Tracking, cloud: Cloud, hooks: Hooks) -> Tracking:
    """The run, with its first pose if this is the first cloud that shows somebody."""
    enough = len(cloud.points) >= run.clouds.settings.tracking.least_points
    shows = enough if run.clouds.have_depth else isinstance(run.init, Pose)
    if run.started or not shows:
        return run
    return run.from_pose(cloud.frame, first_pose(run, cloud, hooks))


def _with_heading(run: Tracking, cloud: Cloud, estimate: Estimate) -> Tracking:
    if run.heading is None or not isinstance(run.model, PersonModel):
        return run
    pose = estimate.pose if estimate.tracked else None
    is_last = cloud.frame == run.clouds.frames[-1]
    heading = run.heading.updated(run.model.finder, pose, cloud, is_last=is_last)
    return dataclasses.replace(run, heading=heading)
