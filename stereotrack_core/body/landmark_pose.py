"""A pose from places of the landmarks in space."""

from __future__ import annotations

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.pose import HANGING, Pose, hanging_pose, rotation_towards
from stereotrack_core.body.skeleton import FOREARMS, HEAD, THIGHS, TORSO, UPPER_ARMS
from stereotrack_core.recording.landmarks import LANDMARKS


def pose_of_landmarks(points: FloatArray) -> Pose:
    """Pose whose limbs point where the landmarks say.

    The torso's long axis runs from hip to shoulder midpoint, its x axis as near to the line
    through the shoulders as can be; limbs are turned by the smallest angle from hanging. Legs
    hang, an unknown head is upright.

    `points` (9, 3), world, metres.

    Raises ValueError where a landmark other than the head is not known or two of a limb are the
    same.
    """
    at = dict(zip(LANDMARKS, np.asarray(points, dtype=np.float64), strict=True))
    hips = (at["left_hip"] + at["right_hip"]) / 2.0
    shoulders = (at["left_shoulder"] + at["right_shoulder"]) / 2.0
    z = _direction(shoulders - hips)
    y = _direction(np.cross(z, at["right_shoulder"] - at["left_shoulder"]))
    torso = np.stack([np.cross(y, z), y, z], axis=-1)
    rotations = hanging_pose(hips, torso).rotations.copy()
    if np.isfinite(at["head"]).all():
        upright = np.eye(3)
        rotations[HEAD] = rotation_towards(upright, torso.T @ _direction(at["head"] - shoulders))
    for side, upper_arm, forearm in zip(("left", "right"), UPPER_ARMS, FOREARMS, strict=True):
        shoulder, elbow, hand = (at[f"{side}_{name}"] for name in ("shoulder", "elbow", "hand"))
        rotations[upper_arm] = rotation_towards(HANGING, torso.T @ _direction(elbow - shoulder))
        world_from_upper = rotations[TORSO] @ rotations[upper_arm]
        along = world_from_upper.T @ _direction(hand - elbow)
        rotations[forearm] = rotation_towards(np.eye(3), along)
    for thigh in THIGHS:
        rotations[thigh] = torso.T @ HANGING
    return Pose(hips, rotations)


def _direction(vector: FloatArray) -> FloatArray:
    length = float(np.linalg.norm(vector))
    if not length > 0:
        raise ValueError("two landmarks coincide, or one is not known")
    return vector / length
