"""What every fit of one recording and person shares."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from stereotrack_core.annotation.click import Click
from stereotrack_core.annotation.fit.depth import MeasuredDepth, measured_depth
from stereotrack_core.annotation.fit.residuals import Clicks, undistorted_clicks
from stereotrack_core.annotation.fit.settings import FitSettings
from stereotrack_core.annotation.fit.start import standing, watched_place
from stereotrack_core.annotation.fit.state import Freedom, Movement, pose_sigmas
from stereotrack_core.annotation.fit.stretch import FrameData, Stretch
from stereotrack_core.annotation.landmark_set import NINE, LandmarkSet
from stereotrack_core.arrays import IntArray
from stereotrack_core.body.model import BodyModel, body_model
from stereotrack_core.body.parameters import BodyParameters
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.proportions import Proportions
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.shape_fit import SeenPose, fitted_shape

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
    shape: BodyParameters,
) -> BodyParameters:
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
    return fitted_shape(proportions, shape, seen, parameters, joints)


CLICKED_SHAPE = BodyParameters(girdle=False)
"""Surface to begin with. Clicks shift the joints of the shoulders themselves, which says more."""


@dataclass(frozen=True, eq=False)
class FitContext:
    """Cameras, person and parameters.

    Attributes
    ----------
    cameras : mapping from camera name to Camera
    asked : LandmarkSet
        The set that is clicked.
    body : BodyModel
    shape : BodyParameters or None
        The body's surface, where it is known.
    settings : FitSettings
    fps : float
        Frame sets per second.
    views : mapping from camera name to view name
        How people call the cameras.
    """

    cameras: Mapping[str, Camera]
    asked: LandmarkSet
    body: BodyModel
    shape: BodyParameters | None
    settings: FitSettings
    fps: float
    views: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def whole(self) -> LandmarkSet:
        """The set that is clicked, and after it what is missing of the nine landmarks."""
        names = self.asked.names
        missing = [one for one in NINE.landmarks if one.name not in names]
        extra = tuple(dataclasses.replace(one, mirror="") for one in missing)
        return LandmarkSet(self.asked.name, (*self.asked.landmarks, *extra))

    @cached_property
    def by_clicks(self) -> Stretch:
        """Fits clicks alone."""
        return self._stretch(with_depth=False)

    @cached_property
    def by_depth(self) -> Stretch:
        """Fits clicks and measured points."""
        return self._stretch(with_depth=True)

    def _stretch(self, *, with_depth: bool) -> Stretch:
        freedom = Freedom(self.whole, self.body, with_depth)
        return Stretch(freedom, self.settings, Movement(freedom, self.settings, self.fps))

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
            cloud = measured_depth(cloud, s.depth_points, outlines=s.use_outlines)
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
        return dataclasses.replace(self, body=body_model(lengths, shape), shape=shape)
