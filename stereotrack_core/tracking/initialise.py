"""Where a track begins."""

from __future__ import annotations

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import Pose, t_pose
from stereotrack_core.body.skeleton import HEAD

_CROWN = 98.5
"""Percentile of the height over the middle that is taken for the top of the head."""

_AROUND = 0.3
"""Metres around the middle in which the head is looked for; strays lie elsewhere."""


def t_pose_in_cloud(body: BodyModel, points: FloatArray) -> Pose:
    """T pose facing north, put where the cloud is: its middle, and its top for the head.

    Parameters
    ----------
    body : BodyModel
    points : (N, 3) float64, world
        Cloud with at least one point.
    """
    middle = np.median(points[:, :2], axis=0)
    around = np.linalg.norm(points[:, :2] - middle, axis=1) < _AROUND
    top = float(np.percentile(points[around, 2], _CROWN))
    return t_pose(np.append(middle, top - crown_over_hips(body)))


def crown_over_hips(body: BodyModel) -> float:
    """Height of the top of the head over the hip midpoint of an upright body, metres."""
    cones = body.cones
    head = np.flatnonzero((cones.part == HEAD) & cones.round_end)[0]
    crown = cones.origins[head, 2] + cones.height[head] + cones.r2[head]
    return float(body.skeleton.joints[HEAD, 2] + crown)
