"""Follow a person by keypoints in several ordinary cameras, without any cloud.

The filter is the one that follows clouds. What a search in the cloud does for that one,
triangulated keypoints do here: in every frame they propose a pose, which is taken where it fits
clearly better.
"""

from stereotrack_core.body.pose import Pose
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.initialise.keypoint_pose import pose_of_keypoints
from stereotrack_core.tracking.residuals.reprojection import KeypointObservation
from stereotrack_core.tracking.state import State
from stereotrack_core.tracking.step import FollowedModel, PersonState
from stereotrack_core.tracking.step_recorder import StepRecorder

_FEWEST = 6  # keypoints of all cameras without which no pose is told
_WORST = 0.6  # cost of the keypoints from which a pose does not explain them
_BETTER = 0.08  # cost by which a pose from triangulated keypoints must fit better to be taken


class KeypointModel(FollowedModel):
    """A person who is followed from keypoints to keypoints.

    A pose that is found is taken at once: no other pose is on trial beside it.
    """

    def step(
        self, state: PersonState, cloud: Cloud, recorder: StepRecorder | None = None
    ) -> tuple[PersonState, Estimate]:
        """Follow to the next frame's keypoints."""
        seen, before = cloud.keypoints, state.leader
        if seen is None or seen.count < _FEWEST:
            count = 0 if seen is None else seen.count
            return self._lost(before, cloud, f"there are only {count} keypoints")
        proposed = pose_of_keypoints(seen, self.setup.body, state.pose if state.present else None)
        if not state.present:
            if proposed is None:
                return self._lost(before, cloud, "shoulders and hips are not seen by two cameras")
            state = self.first(proposed, cloud.frame)
            if recorder is not None:
                recorder.reinitialised()
        leader, estimate = self.follower.step(state.leader, cloud, recorder)
        cost = self._cost(cloud, leader.pose)
        if proposed is not None and self._cost(cloud, proposed) < cost - _BETTER:
            start = self.setup.first_state(proposed, cloud.frame)
            other, found = self.follower.tried(start, leader, cloud, recorder)
            other_cost = self._cost(cloud, other.pose)
            if found.tracked and other_cost < cost - _BETTER:
                leader, estimate, cost = other, found, other_cost
        if cost > _WORST:
            return self._lost(before, cloud, "the keypoints do not match the body")
        return PersonState(leader), estimate

    def _cost(self, cloud: Cloud, pose: Pose) -> float:
        seen = KeypointObservation(cloud.keypoints, self.setup.parameters.keypoint_sigma)
        fit = seen.fitted(self.setup.body, pose)
        return 1.0 if fit is None else fit.cost()

    def _lost(self, before: State, cloud: Cloud, reason: str) -> tuple[PersonState, Estimate]:
        after, estimate = self.follower.lost(before, cloud, reason)
        return self.absent(after.pose), estimate
