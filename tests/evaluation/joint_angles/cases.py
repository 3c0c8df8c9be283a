"""Landmarks of bodies whose joint angles are known beforehand."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from stereotrack_core.recording.landmarks import LANDMARKS

# the recommendation's X (forwards), Y (up), Z (right) in the torso's frame (right, forwards, up)
TORSO_FROM_ISB = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
MIRROR = np.diag([-1.0, 1.0, 1.0])


def humerus(plane, elevation, rotation):
    """thorax_from_humerus by the recommendation's own formula, Y-X'-Y'' with beta = -elevation."""
    return Rotation.from_euler("YXY", [plane, -elevation, rotation]).as_matrix()


def landmarks(arms=None, torso=None, head=(0.0, 0.0, 1.0)):
    """Nine landmarks (9, 3) of a body.

    `arms` are (plane, elevation, rotation, flexion) of the left and the right one, in radians; the
    forearm is bent about the humerus' own Z. `torso` is world_from_torso, `head` its direction.
    """
    torso = np.eye(3) if torso is None else torso
    arms = ((0.3, 0.4, 0.1, 0.5),) * 2 if arms is None else arms
    points = {
        "left_hip": [-0.12, 0, 0], "right_hip": [0.12, 0, 0],
        "left_shoulder": [-0.19, 0, 0.46], "right_shoulder": [0.19, 0, 0.46],
        "head": np.array([0, 0, 0.46]) + 0.2 * np.asarray(head, float),
    }  # fmt: skip
    for side, (plane, elevation, rotation, flexion) in zip(("left", "right"), arms, strict=True):
        own = humerus(plane, elevation, rotation)
        upper = TORSO_FROM_ISB @ own @ [0.0, -1.0, 0.0]
        bend = Rotation.from_euler("Z", flexion).as_matrix()
        fore = TORSO_FROM_ISB @ own @ bend @ [0.0, -1.0, 0.0]
        if side == "left":
            upper, fore = MIRROR @ upper, MIRROR @ fore
        points[f"{side}_elbow"] = points[f"{side}_shoulder"] + 0.27 * upper
        points[f"{side}_hand"] = points[f"{side}_elbow"] + 0.36 * fore
    return np.array([points[name] for name in LANDMARKS]) @ torso.T + [1.0, 2.0, 0.9]


def torso_of(turn, forward, sideways):
    """world_from_torso by the recommendation's Y, X and Z axes one after the other."""
    isb = Rotation.from_euler("YXZ", [turn, sideways, -forward]).as_matrix()
    return TORSO_FROM_ISB @ isb @ TORSO_FROM_ISB.T
