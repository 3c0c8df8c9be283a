"""Where a track begins."""

from __future__ import annotations

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import Pose, t_pose
from stereotrack_core.body.skeleton import HEAD

_CROWN = 99.7
"""Percentile of the cloud's height that is taken for the top of the head."""


def t_pose_in_cloud(body: BodyModel, points: FloatArray) -> Pose:
    """T pose facing north, put where the cloud is: its middle, and its top for the head.

    Parameters
    ----------
    body : BodyModel
    points : (N, 3) float64, world
        Cloud with at least one point.
    """
    middle = np.median(points[:, :2], axis=0)
    top = float(np.percentile(points[:, 2], _CROWN))
    return t_pose(np.append(middle, top - crown_over_hips(body)))


def crown_over_hips(body: BodyModel) -> float:
    """Height of the top of the head over the hip midpoint of an upright body, metres."""
    cones = body.cones
    head = np.flatnonzero((cones.part == HEAD) & cones.round_end)[0]
    crown = cones.origins[head, 2] + cones.height[head] + cones.r2[head]
    return float(body.skeleton.joints[HEAD, 2] + crown)
