"""Find the body without help, and find it again when it was away."""

from __future__ import annotations

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import Pose
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.tracking.confidence import coverage, surface_distances
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.initialise import standing_poses
from stereotrack_core.tracking.manifold_tracker import ManifoldTracker
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.search.search import ArmSearch

_HEADINGS = 8
"""Directions that a body is tried in when nothing is known."""

_ALL_DATA = 450.0
"""Weight of all data against the search's cost, which counts those near the shoulders."""


class SeekingTracker(ManifoldTracker):
    """Follow the body, and look for it wherever it was not there a frame before.

    Parameters are those of :class:`ManifoldTracker`.
    """

    def __init__(
        self,
        body: BodyModel,
        parameters: TrackingParameters,
        cameras: FloatArray,
        fps: float,
        seed: int,
    ) -> None:
        super().__init__(body, parameters, cameras, fps, seed)
        self._arms = ArmSearch(body, parameters.search)

    def start(self, pose: Pose) -> None:
        """Begin from a pose that is roughly right."""
        super().start(pose)
        self._present = True

    def step(self, cloud: Cloud) -> Estimate:
        """Follow to the next cloud; look for the body first where it was lost."""
        if not self._present and len(cloud.points) >= self.parameters.least_points:
            self.acquire(cloud)
        estimate = super().step(cloud)
        self._present = estimate.tracked
        return estimate

    def acquire(self, cloud: Cloud) -> None:
        """Find the body: where it was last, or standing in the cloud and facing anywhere."""
        found = []
        data = self.choose(cloud)
        for pose in (self.pose, *standing_poses(self.body, cloud.points, _HEADINGS)):
            self.start(pose)
            self.track(cloud, data)
            rng = np.random.default_rng((self._seed, cloud.frame, 2))
            evidence = self._arms.evidence(cloud, self.pose, rng)
            unexplained = coverage(surface_distances(data, self.body, self.pose))
            cost = self._arms.cost(evidence, self.pose, self.pose)
            found.append((cost + _ALL_DATA * unexplained, self.pose))
        self.start(min(found, key=lambda candidate: candidate[0])[1])
