"""Data that all fits of one recording and person share, and the poses that they begin from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.fit.residuals import Clicks, undistorted_clicks
from stereotrack_core.annotation.fit.state import FitSettings, Freedom, pose_sigmas
from stereotrack_core.annotation.fit.stretch import (
    FrameData,
    MeasuredDepth,
    Stretch,
    measured_depth,
)
from stereotrack_core.annotation.landmark_set import NINE, LandmarkSet
from stereotrack_core.annotation.predict import watched_point
from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.model import BodyModel, body_model
from stereotrack_core.body.parameters import BodyShape
from stereotrack_core.body.pose import Pose, hanging_pose
from stereotrack_core.body.posing import pose_showing
from stereotrack_core.body.proportions import Proportions
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.triangulation import Sightings, point_of_sightings
from stereotrack_core.recording.description import Cameras
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.shape_fit import SeenPose, fitted_shape

_LEAST_SIGMA = 3.0  # pixels; calibrations are no better than that
_DISTANCE = 3.0  # metres in front of a lone camera at which somebody is looked for


def watched_place(cameras: Cameras) -> FloatArray:
    """The point (3,), world, that the cameras look at together."""
    return watched_point(tuple(cameras.values()), _DISTANCE) if cameras else np.zeros(3)


def standing(body: BodyModel, middle: FloatArray, yaw: float = 0.0) -> Pose:
    """The usual pose: upright, arms hanging, the middle of the trunk at a place (3,)."""
    torso = rotation_from_vector(np.array([0.0, 0.0, yaw]))
    half = 0.5 * body.skeleton.proportions.torso_length
    return hanging_pose(middle - np.array([0.0, 0.0, half]), torso)


def triangulated(clicks: Clicks, landmarks: int) -> FloatArray:
    """Points (L, 3), world, that most clicks of a frame agree with; NaN where there are none."""
    points = np.full((landmarks, 3), np.nan)
    for landmark in np.unique(clicks.landmark):
        own = clicks.landmark == landmark
        places = clicks.rotations[own], clicks.translations[own], clicks.normalised[own]
        sigma = np.maximum(clicks.sigma[own], _LEAST_SIGMA)
        found = point_of_sightings(Sightings(*places, clicks.raw_from_normalised[own], sigma))
        if found is not None:
            points[landmark] = found.world
    return points


def filled_over_time(points: FloatArray) -> FloatArray:
    """Points (F, L, 3) with what is missing between known frames; NaN where never known."""
    filled = points.copy()
    frames = np.arange(len(points))
    for i in range(points.shape[1]):
        known = np.isfinite(points[:, i]).all(axis=1)
        if known.any():
            for axis in range(3):
                filled[:, i, axis] = np.interp(frames, frames[known], points[known, i, axis])
    return filled


def pose_at(points: FloatArray, body: BodyModel, landmark_set: LandmarkSet, usual: Pose) -> Pose:
    """Pose that shows the points (L, 3) that are known; what they do not tell is as usual."""
    rows = zip(landmark_set.names, points, strict=True)
    known = {n: at for n, at in rows if n in NINE.names and np.isfinite(at).all()}
    return pose_showing(known, body, usual)


_FRAMES, _FEWEST = 12, 3  # frames that the shape is fitted to, and fewest; else the average one
_ROUNDS = 6
_NEAR = (0.05, 10.0, 15.0)  # error of a pose fitted to clicks: m; deg of torso, of a joint
CLICKED_SHAPE = BodyShape(girdle=False)  # to begin with; clicks themselves shift the shoulders


@dataclass(frozen=True, eq=False)
class FitContext:
    """Cameras by name, landmarks that are clicked, person, frame rate, and names of the views."""

    cameras: Cameras
    asked: LandmarkSet
    proportions: Proportions
    settings: FitSettings = field(default_factory=FitSettings)
    fps: float = 10.0
    views: Mapping[str, str] = field(default_factory=dict)
    shape: BodyShape | None = None

    @cached_property
    def body(self) -> BodyModel:
        """The person's body, as far as it is known."""
        return body_model(self.proportions, self.shape or CLICKED_SHAPE)

    @cached_property
    def whole(self) -> LandmarkSet:
        """The set that is clicked, and after it what is missing of the nine landmarks."""
        names = self.asked.names
        extra = [replace(one, mirror="") for one in NINE.landmarks if one.name not in names]
        return LandmarkSet(self.asked.name, (*self.asked.landmarks, *extra))

    @cached_property
    def by_clicks(self) -> Stretch:
        """Fits clicks alone."""
        return Stretch(Freedom(self.whole, self.body, False), self.settings, self.fps)

    @cached_property
    def by_depth(self) -> Stretch:
        """Fits clicks and measured points."""
        return Stretch(Freedom(self.whole, self.body, True), self.settings, self.fps)

    @cached_property
    def usual(self) -> Pose:
        """Where somebody stands of whom nothing is known."""
        return standing(self.body, watched_place(self.cameras))

    def data(self, measurements: Sequence[Click], cloud: Cloud | MeasuredDepth | None) -> FrameData:
        """Clicks of a frame, and its depth where that is used."""
        s, names = self.settings, self.whole.names
        clicks = undistorted_clicks(measurements, self.cameras, names, s.outlier_share)
        if cloud is None or not s.use_depth:
            return FrameData(clicks)
        if isinstance(cloud, Cloud):
            cloud = measured_depth(cloud)
        return FrameData(clicks, cloud)

    def shaped(
        self, data: Sequence[FrameData], poses: Sequence[Pose], known: IntArray
    ) -> FitContext:
        """The same with the person's surface and outline, if enough `known` frames show them."""
        if self.shape is not None:
            return self
        deep = np.array([k for k in known if data[k].depth is not None], dtype=np.int64)
        if len(deep) < _FEWEST:
            return replace(self, shape=CLICKED_SHAPE)
        chosen = deep[np.linspace(0, len(deep) - 1, min(_FRAMES, len(deep))).round().astype(int)]
        stretch, seen = self.by_depth, []
        sigma = pose_sigmas(stretch.freedom, *_NEAR)
        for k in chosen:
            depth = data[k].depth
            assert depth is not None  # noqa: S101 - frames with depth were chosen
            found = stretch.fit([data[k]], [poses[k]], poses[k], sigma, rounds=_ROUNDS)
            seen.append(SeenPose(depth.points, found.states[0].pose, depth.edges()))
        shape = fitted_shape(self.body, seen, TrackingParameters(), stretch.freedom.joints)
        return replace(self, shape=shape)
