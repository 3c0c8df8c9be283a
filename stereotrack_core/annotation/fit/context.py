"""What every fit of one recording and person shares."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from stereotrack_core.annotation.fit.measurement import ClickMeasurement
from stereotrack_core.annotation.fit.movement import Movement
from stereotrack_core.annotation.fit.residuals import Clicks, undistorted_clicks
from stereotrack_core.annotation.fit.settings import FitSettings
from stereotrack_core.annotation.fit.start import standing, watched_place
from stereotrack_core.annotation.fit.state import Freedom
from stereotrack_core.annotation.fit.stretch import FrameData, Stretch
from stereotrack_core.annotation.landmark_set import NINE, LandmarkSet
from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import Pose
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.geometry.camera import Camera


@dataclass(frozen=True, eq=False)
class FitContext:
    """Cameras, person and parameters.

    Attributes
    ----------
    cameras : mapping from camera name to Camera
    asked : LandmarkSet
        The set that is clicked.
    body : BodyModel
    settings : FitSettings
    fps : float
        Frame sets per second.
    views : mapping from camera name to view name
        How people call the cameras.
    """

    cameras: Mapping[str, Camera]
    asked: LandmarkSet
    body: BodyModel
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

    def clicks(self, measurements: Sequence[ClickMeasurement]) -> Clicks:
        """Clicks of one frame, freed from the distortion of their lenses."""
        return undistorted_clicks(measurements, self.cameras, self.whole.names)

    def data(self, measurements: Sequence[ClickMeasurement], cloud: Cloud | None) -> FrameData:
        """What is known of a frame; the cloud only where it is to be used."""
        if cloud is None or not self.settings.use_depth:
            return FrameData(self.clicks(measurements))
        return FrameData(self.clicks(measurements), self._chosen(cloud))

    def _chosen(self, cloud: Cloud) -> FloatArray:
        """Points (N, 3) drawn evenly from the cloud; the same for the same frame."""
        wanted, there = self.settings.depth_points, len(cloud.points)
        if there <= wanted:
            return cloud.points
        rng = np.random.default_rng(cloud.frame)
        return cloud.points[np.sort(rng.choice(there, wanted, replace=False))]
