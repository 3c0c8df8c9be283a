"""Poses that show known points: of the trunk as a whole, then along every limb."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel, landmarks
from stereotrack_core.body.pose import Pose, rotation_towards
from stereotrack_core.body.skeleton import FOREARMS, HEAD, PARENTS, TORSO, UPPER_ARMS
from stereotrack_core.recording.landmarks import LANDMARKS

TRUNK = ("left_shoulder", "right_shoulder", "head", "left_hip", "right_hip")
"""Landmarks that tell where the trunk is."""

_CHAINS = {
    UPPER_ARMS[0]: "left_elbow",
    UPPER_ARMS[1]: "right_elbow",
    FOREARMS[0]: "left_hand",
    FOREARMS[1]: "right_hand",
    HEAD: "head",
}
"""The landmark at the far end of a part."""


def pose_showing(known: Mapping[str, FloatArray], body: BodyModel, usual: Pose) -> Pose:
    """Pose that shows points (3,), world, of some of the nine landmarks, by name.

    What they do not tell is as usual.
    """
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
