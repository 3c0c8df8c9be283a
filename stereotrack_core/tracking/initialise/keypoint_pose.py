"""A pose from keypoints alone: where rays of several cameras meet, the body's joints are."""

from collections.abc import Mapping

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel, landmarks
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.posing import pose_of_landmarks
from stereotrack_core.recording.keypoint_names import exchanged
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.recording.sighted_keypoints import SightedKeypoints, points_by_name
from stereotrack_core.tracking.residuals.reprojection import MEETING_GATE

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
