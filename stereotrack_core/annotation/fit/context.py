"""What every fit of one recording and person shares, and the poses that it begins from.

These show triangulated landmarks, and the usual pose for the rest.
"""

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
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.triangulation import Sightings, point_of_sightings
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.shape_fit import SeenPose, fitted_shape

_LEAST_SIGMA = 3.0  # pixels; calibrations are no better than that
_DISTANCE = 3.0  # metres in front of a lone camera at which somebody is looked for


def watched_place(cameras: Mapping[str, Camera]) -> FloatArray:
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
    for landmark in range(landmarks):
        own = clicks.landmark == landmark
        found = point_of_sightings(
            Sightings(
                clicks.rotations[own],
                clicks.translations[own],
                clicks.normalised[own],
                clicks.raw_from_normalised[own],
                np.maximum(clicks.sigma[own], _LEAST_SIGMA),
            )
        )
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
    """Pose that shows the points (L, 3) of the set that are known, others being NaN.

    What they do not tell is as usual.
    """
    known = {
        name: point
        for name, point in zip(landmark_set.names, points, strict=True)
        if name in NINE.names and np.isfinite(point).all()
    }
    return pose_showing(known, body, usual)


_FRAMES, _FEWEST = 12, 3
"""Frames that the shape is fitted to, and those without which the average one is better."""

_ROUNDS = 6

_NEAR = (0.05, 10.0, 15.0)
"""How far a pose fitted to clicks may be off: metres; degrees of the torso, of a joint."""


def _clicked_shape(
    stretch: Stretch,
    data: Sequence[FrameData],
    poses: Sequence[Pose],
    known: IntArray,
    proportions: Proportions,
    shape: BodyShape,
) -> BodyShape:
    """Surface and outline of the person; the given one where too few frames show them."""
    if len(known) < _FEWEST:
        return shape
    chosen = known[np.linspace(0, len(known) - 1, min(_FRAMES, len(known))).round().astype(int)]
    sigma = pose_sigmas(stretch.freedom, *_NEAR)
    seen = []
    for k in chosen:
        depth = data[k].depth
        assert depth is not None  # noqa: S101 - the caller asked for frames with depth
        found = stretch.fit([data[k]], [poses[k]], poses[k], sigma, rounds=_ROUNDS)
        seen.append(SeenPose(depth.points, found.states[0].pose, depth.edges()))
    parameters, joints = TrackingParameters(), stretch.freedom.joints
    return fitted_shape(body_model(proportions, shape), seen, parameters, joints)


CLICKED_SHAPE = BodyShape(girdle=False)
"""Surface to begin with. Clicks shift the joints of the shoulders themselves, which says more."""


@dataclass(frozen=True, eq=False)
class FitContext:
    """Cameras, person and parameters.

    The set of landmarks that is `asked` for is clicked; `shape` is the body's surface, where it is
    known; `views` say how people call the cameras.
    """

    cameras: Mapping[str, Camera]
    asked: LandmarkSet
    body: BodyModel
    shape: BodyShape | None
    settings: FitSettings
    fps: float
    views: Mapping[str, str] = field(default_factory=dict)

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

    def clicks(self, measurements: Sequence[Click]) -> Clicks:
        """Clicks of one frame, freed from the distortion of their lenses."""
        return undistorted_clicks(measurements, self.cameras, self.whole.names)

    def data(self, measurements: Sequence[Click], cloud: Cloud | MeasuredDepth | None) -> FrameData:
        """What is known of a frame; depth only where it is to be used."""
        clicks, s = self.clicks(measurements), self.settings
        if cloud is None or not s.use_depth:
            return FrameData(clicks)
        if isinstance(cloud, Cloud):
            cloud = measured_depth(cloud, silhouettes=s.use_silhouettes)
        return FrameData(clicks, cloud)

    def shaped(
        self, data: Sequence[FrameData], poses: Sequence[Pose], known: IntArray
    ) -> FitContext:
        """The same with the person's own surface, as far as `known` frames show it."""
        if self.shape is not None or not self.settings.fit_shape:
            return self
        deep = np.array([k for k in known if data[k].depth is not None], dtype=np.int64)
        lengths = self.body.skeleton.proportions
        shape = _clicked_shape(self.by_depth, data, poses, deep, lengths, CLICKED_SHAPE)
        return replace(self, body=body_model(lengths, shape), shape=shape)
