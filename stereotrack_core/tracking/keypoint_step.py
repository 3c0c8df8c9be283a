"""Follow a person by keypoints in several ordinary cameras, without any cloud.

The filter is the one that follows clouds. What a search in the cloud does for that one,
triangulated keypoints do here: in every frame they propose a pose, which is taken where it fits
clearly better.
"""

from collections.abc import Mapping

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel, landmarks
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.posing import pose_of_landmarks
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.recording.keypoint_names import exchanged
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.recording.sighted_keypoints import SightedKeypoints, points_by_name
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.residuals.reprojection import MEETING_GATE, KeypointObservation
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


_SIDES = ("left", "right")
_TRUNK = ("left_shoulder", "right_shoulder", "left_hip", "right_hip")


def pose_of_keypoints(
    seen: SightedKeypoints, body: BodyModel, last: Pose | None = None
) -> Pose | None:
    """Pose whose limbs point from joint to joint where cameras see them; also which way it faces.

    Shoulders and one hip, or both hips and one shoulder, have to be seen by two cameras. Arms that
    are not seen are as in the last pose, or hang.
    """
    points = points_by_name(seen.names, seen.meeting(MEETING_GATE))
    trunk = _trunk(points, body)
    if trunk is None:
        return None
    found = dict(zip(LANDMARKS, np.full((len(LANDMARKS), 3), np.nan), strict=True)) | trunk
    of_head = ("head",) if "head" in points else ("left_ear", "right_ear", "nose")
    if head := [points[name] for name in of_head if name in points]:
        found["head"] = np.mean(head, axis=0)
    p = body.skeleton.proportions
    for side in _SIDES:
        elbow, hand, wrist = (points.get(f"{side}_{name}") for name in ("elbow", "hand", "wrist"))
        if hand is None and wrist is not None and elbow is not None:
            hand = elbow + (wrist - elbow) * (p.elbow_to_hand / p.forearm_length)
        if elbow is not None:
            found[f"{side}_elbow"] = elbow
        if hand is not None:
            found[f"{side}_hand"] = hand
    try:
        return pose_of_landmarks(_completed(found, body, last))
    except ValueError:
        return None


def _trunk(points: Mapping[str, FloatArray], body: BodyModel) -> dict[str, FloatArray] | None:
    """Shoulders and hips; one that is missing is opposite to its other side."""
    found = {name: points[name] for name in _TRUNK if name in points}
    if len(found) < len(_TRUNK) - 1:
        return None
    p = body.skeleton.proportions
    widths = ("shoulder", "hip", p.shoulder_width), ("hip", "shoulder", p.hip_width)
    for joint, other, width in widths:
        for side, sign in (("left", -1.0), ("right", 1.0)):
            name = f"{side}_{joint}"
            if name not in found:
                across = found[f"right_{other}"] - found[f"left_{other}"]
                across = across / max(float(np.linalg.norm(across)), 1e-9)
                found[name] = found[exchanged(name)] + sign * width * across
    return found


def _completed(found: Mapping[str, FloatArray], body: BodyModel, last: Pose | None) -> FloatArray:
    """The landmarks (9, 3), arms that are not known as in the last pose, or hanging."""
    points = np.array([found[name] for name in LANDMARKS])
    before = None if last is None else landmarks(body, last)
    p, at = body.skeleton.proportions, LANDMARKS.index
    for side in _SIDES:
        below = points[at(f"{side}_hip")] - points[at(f"{side}_shoulder")]
        above = at(f"{side}_shoulder")
        lengths = (("elbow", p.upper_arm_length), ("hand", p.elbow_to_hand))
        for name, length in lengths:
            own = at(f"{side}_{name}")
            if not np.isfinite(points[own]).all():
                down = length * below / max(float(np.linalg.norm(below)), 1e-9)
                points[own] = points[above] + (
                    down if before is None else before[own] - before[above]
                )
            above = own
    return points
