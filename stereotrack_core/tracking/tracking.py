"""A run under way as a value, and its step from one frame to the next."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from stereotrack_core.body.model import BodyModel, body_model, landmarks
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.depth.chain import DepthChain, OnPart
from stereotrack_core.depth.cloud import FRAMES_APART, Cloud, contradicted_share
from stereotrack_core.depth.parameters import DepthParameters
from stereotrack_core.depth.volume import settled
from stereotrack_core.plain_data import plain
from stereotrack_core.pose_model.installation import detector_versions
from stereotrack_core.recording.description import Recording
from stereotrack_core.recording.detections import Detections
from stereotrack_core.recording.folder import calibration_fingerprint, fingerprint
from stereotrack_core.recording.keypoints import Keypoints
from stereotrack_core.tracking.clouds import Clouds
from stereotrack_core.tracking.frame import (
    DETECTED_SCENES,
    LOOKED_AGAIN,
    FirstFrame,
    Origin,
    TrackedFrame,
)
from stereotrack_core.tracking.initialise.first_pose import facing, first_pose_in
from stereotrack_core.tracking.initialise.heading import HeadingWatch
from stereotrack_core.tracking.initialise.seeds import t_pose_in_cloud
from stereotrack_core.tracking.model import (
    TrackModel,
    TrackState,
    cameras_of,
    initialiser,
    model_for,
    step,
)
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.run_spec import FirstPose, Hooks, given_heading, is_found
from stereotrack_core.tracking.saved_state import Arrays, saved
from stereotrack_core.tracking.second_look import SecondLook, is_sure
from stereotrack_core.tracking.step import PersonModel
from stereotrack_core.version import __version__
from stereotrack_core.versions import versions

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
        clouds, recording, colour = self.clouds, self.recording, self.clouds.reader.colour
        spec = dataclasses.replace(
            clouds.spec, views=clouds.views, frames=clouds.frames, init=self.init, colour=colour
        )
        used, asked = clouds.chain.parameters.values(), spec.settings.depth.values()
        pose, began = spec.init if isinstance(spec.init, Pose) else None, self.began
        subject, heading = recording.subject, self.heading
        meta = {
            "program": "stereotrack",
            "version": __version__,
            "preset": spec.preset,
            "parameters": spec.settings.values(),
            "body": self.body.shape.values(),
            "seed": spec.seed,
            "views": list(clouds.views),
            "init": spec.init if pose is None else self.given,
            "fps": recording.fps,
            "recording": recording.name,
            "recording_folder": str(recording.folder.resolve()),
            "fingerprint": fingerprint(recording),
            "subject": None if subject is None else plain(subject),
            "smoothed": False,
            "bridged": [],  # untracked frames with poses of the backward pass
            "first_pose": None if pose is None else pose.values(),
            "began": None if began is None else began.frame,
            "began_from": None if began is None else began.pose.values(),
            "frames": [clouds.frames.start, clouds.frames.stop],
            "detections": _described(clouds.detections),
            "keypoints": _described(spec.used_keypoints),
            "clicks": _described(spec.clicks),
            "detector": "" if clouds.detector is None else clouds.detector.name,
            DETECTED_SCENES: list(clouds.chain.silhouettes.made),
            "colour": spec.colour,
            "calibration": calibration_fingerprint(recording),
            "versions": versions() | detector_versions(),
            "made": self.made,
            "resumed_at": list(self.resumed_at),
            "heading": None if heading is None else heading.to_dict(),
            LOOKED_AGAIN: [list(stretch) for stretch in self.look.changed],
            "from_recording": dict(used.items() - asked.items()),
        }
        return Origin(spec, self.model.state_names, meta)

    def saved(self) -> Arrays:
        """Arrays from which the run goes on if it is stopped."""
        look = saved(self.look.numbers(), LOOK)
        return {**saved(self.state, TRACK), **look, **saved(self.heading, HEADING)}


def _described(found: Detections | Keypoints | None) -> dict[str, Any] | None:
    """What a run states of keypoints or clicks that it was given."""
    if isinstance(found, Keypoints):
        source: dict[str, Any] = {"sources": sorted(set(found.source.tolist()))}
    elif found:
        source = {"source": found.source}
    else:
        return None
    return {**source, "fingerprint": found.fingerprint(), "count": len(found)}


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
    enough = len(cloud.points) >= clouds.settings.tracking.least_points
    shows_somebody = enough if clouds.have_depth else isinstance(run.init, Pose)
    if not run.started and shows_somebody:
        run = run.from_pose(cloud.frame, first_pose(run, cloud, hooks))
    state, estimate = step(run.model, run.state, cloud)
    heading = run.heading
    if heading is not None and isinstance(run.model, PersonModel):
        pose, is_last = (
            estimate.pose if estimate.tracked else None,
            cloud.frame == clouds.frames[-1],
        )
        heading = heading.updated(run.model.finder, pose, cloud, is_last=is_last)
    run = dataclasses.replace(run, state=state, heading=heading)
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
    settings, told = run.clouds.settings, partial(hooks.on_preparing, "finding the initial pose")
    model = initialiser_of(run)
    if settings.follows_data:
        found = first_pose_in(model, clouds, told)
    else:
        found = _looked_for_in_images(run, model, [cloud.frame for cloud in clouds], told)
    heading, upright = given_heading(run.init), settings.depth.upright
    return None if found is None else facing(found, heading, upright)


def _looked_for_in_images(
    run: Tracking, model: PersonModel, frames: Sequence[int], told: OnPart
) -> Pose | None:
    """First pose for a tracker whose own clouds are not made for search, followed to its place.

    Depth parameters keep their defaults, except those that differ from the preset ``thesis``.
    `model` is of the default shape, `frames` are successive.
    """
    reader, views, chosen = run.clouds.reader, run.clouds.views, run.clouds.settings.depth
    usual = {row.name: row.presets.get("thesis", row.default) for row in DepthParameters.rows()}
    changed = {name: value for name, value in chosen.values().items() if value != usual[name]}
    wanted = settled(reader.recording, DepthParameters().replaced(**changed), reader, views)
    with closing(DepthChain(reader.recording, wanted, views=views)) as chain:
        chain.learn_background(reader, run.clouds.frames)
        clouds = [chain.process(reader.frame_set(frame)) for frame in frames]
    found = first_pose_in(model, clouds, told)
    if found is None:
        return None
    state = model.first(found)
    for cloud in clouds:
        state, estimate = model.step(state, cloud)
        if estimate.tracked:
            return estimate.pose
    return found


def initialiser_of(run: Tracking) -> PersonModel:
    """Model that looks for the person's first pose.

    The thesis begins from a known pose; its body, without legs, is not made for search, so that
    another one of the same lengths is looked for.
    """
    setup = run.model.setup
    if not run.clouds.settings.follows_data:
        body = body_model(proportions_of(run.recording.subject))
        setup = dataclasses.replace(setup, body=body, parameters=TrackingParameters())
    return initialiser(setup)
