"""Poses that show known points: of the trunk as a whole, then along every limb."""

from collections.abc import Mapping

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel, landmarks
from stereotrack_core.body.pose import HANGING, Pose, hanging_pose, rotation_towards
from stereotrack_core.body.skeleton import FOREARMS, HEAD, PARENTS, THIGHS, TORSO, UPPER_ARMS
from stereotrack_core.recording.landmarks import LANDMARKS

TRUNK = ("left_shoulder", "right_shoulder", "head", "left_hip", "right_hip")  # trunk landmarks
# The landmark at the far end of a part.
_CHAINS = {
    UPPER_ARMS[0]: "left_elbow",
    UPPER_ARMS[1]: "right_elbow",
    FOREARMS[0]: "left_hand",
    FOREARMS[1]: "right_hand",
    HEAD: "head",
}


def pose_showing(known: Mapping[str, FloatArray], body: BodyModel, usual: Pose) -> Pose:
    """Pose that shows points (3,), world, of some landmarks by name; else as usual."""
    pose = _trunk_at(known, body, usual)
    for part, name in _CHAINS.items():
        if name in known:
            frames = body.frames(pose)
            away = known[name] - frames.origins[part]
            length = float(np.linalg.norm(away))
            if length > 1e-3:
                local = frames.rotations[PARENTS[part]].T @ (away / length)
                rotations = pose.rotations.copy()
                rotations[part] = rotation_towards(usual.rotations[part], local)
                pose = Pose(pose.position, rotations)
    return pose


def _trunk_at(known: Mapping[str, FloatArray], body: BodyModel, usual: Pose) -> Pose:
    names = [name for name in TRUNK if name in known]
    if not names:
        ends = [point for name, point in known.items() if name not in TRUNK]
        if not ends:
            return usual
        middle = 0.5 * body.skeleton.proportions.torso_length * usual.torso[:, 2]
        return Pose(np.mean(ends, axis=0) - middle, usual.rotations)
    own = landmarks(body, usual)[[LANDMARKS.index(name) for name in names]]
    seen = np.array([known[name] for name in names])
    turn = np.eye(3)
    if len(names) > 2:  # Kabsch
        u, _, vt = np.linalg.svd((seen - seen.mean(axis=0)).T @ (own - own.mean(axis=0)))
        turn = u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt
    rotations = usual.rotations.copy()
    rotations[TORSO] = turn @ usual.torso
    shift = seen.mean(axis=0) - turn @ (own.mean(axis=0) - usual.position)
    return Pose(shift, rotations)


def pose_of_landmarks(points: FloatArray) -> Pose:
    """Pose whose limbs point where landmarks (9, 3), world, metres, say.

    The torso's long axis runs from hip to shoulder midpoint; limbs are turned by the smallest angle
    from hanging. Legs hang, an unknown head is upright. Raises ValueError for another unknown
    landmark or a limb of no length.
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
