"""Follow a person by keypoints in several ordinary cameras, without any cloud.

The filter is the one that follows clouds. What a search in the cloud does for that one,
triangulated keypoints do here: in every frame they propose a pose, which is taken where it fits
clearly better.
"""

from __future__ import annotations

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.pose import Pose
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.tracking.estimate import Estimate, Memory
from stereotrack_core.tracking.iekf import LeaderTracker
from stereotrack_core.tracking.initialise.keypoint_pose import pose_of_keypoints
from stereotrack_core.tracking.residuals.reprojection import KeypointFit, KeypointObservation
from stereotrack_core.tracking.step_recorder import StepRecorder

_FEWEST = 6
"""Keypoints of all cameras without which no pose is told."""

_WORST = 0.6
"""Cost of the keypoints from which a pose does not explain them."""

_BETTER = 0.08
"""Cost by which a pose from triangulated keypoints must fit better to be taken."""


class KeypointTracker(LeaderTracker):
    """Follow a person from keypoints to keypoints; find the pose wherever it was not there before.

    What is found is taken at once: no other pose is on trial beside it.
    """

    def start(self, pose: Pose, time: float | None = None, *, P: FloatArray | None = None) -> None:
        """Begin from a pose that is roughly right; see :meth:`PoseFilter.start`."""
        self.leader.start(pose, time, P=P)
        self._present = True

    def step(self, cloud: Cloud, trace: StepRecorder | None = None) -> Estimate:
        """Follow to the next frame's keypoints."""
        before, seen = self.leader.state, cloud.keypoints
        if seen is None or seen.count < _FEWEST:
            count = 0 if seen is None else seen.count
            return self._lost(cloud, f"there are only {count} keypoints")
        proposed = pose_of_keypoints(seen, self.setup.body, self.pose if self._present else None)
        if not self._present:
            if proposed is None:
                return self._lost(cloud, "shoulders and hips are not seen by two cameras")
            self.start(proposed, cloud.frame)
            if trace is not None:
                trace.reinitialised()
        estimate = self.leader.step(cloud, trace)
        cost = self._cost(cloud, self.pose)
        if proposed is not None and self._cost(cloud, proposed) < cost - _BETTER:
            state, limit = self.setup.first_state(proposed, cloud.frame), cost - _BETTER
            other = self.try_from(state, cloud, trace, lambda p: self._cost(cloud, p) < limit)
            if other is not None:
                estimate, cost = other, self._cost(cloud, self.pose)
        if cost > _WORST:
            self.leader.resume(before)
            return self._lost(cloud, "the keypoints do not match the body")
        return estimate

    def memory(self) -> Memory:
        """All that the next step depends on."""
        return {**self.leader.memory(), "present": np.array(self._present)}

    def recall(self, memory: Memory) -> None:
        """Go on as the tracker would whose memory this is."""
        self.leader.recall(memory)
        self._present = bool(memory["present"])

    def _cost(self, cloud: Cloud, pose: Pose) -> float:
        fit = self._fit(cloud, pose)
        return 1.0 if fit is None else fit.cost()

    def _fit(self, cloud: Cloud, pose: Pose) -> KeypointFit | None:
        sigma = self.setup.parameters.keypoint_sigma
        return KeypointObservation(cloud.keypoints, sigma).fitted(self.setup.body, pose)

    def _lost(self, cloud: Cloud, reason: str) -> Estimate:
        estimate = self.leader.lost(self.leader.state, cloud, reason)
        self.reinitialise()
        return estimate
