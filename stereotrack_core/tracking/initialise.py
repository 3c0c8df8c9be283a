"""Where a track begins."""

from __future__ import annotations

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import Pose, hanging_pose, t_pose
from stereotrack_core.body.skeleton import HEAD
from stereotrack_core.geometry.rotation import rotation_from_vector

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
    return t_pose(_hips_under(body, points, middle))


def standing_poses(body: BodyModel, points: FloatArray, headings: int) -> list[Pose]:
    """Upright poses with hanging arms in the middle of the cloud, facing all around.

    Parameters
    ----------
    body : BodyModel
    points : (N, 3) float64, world
        Cloud with at least one point.
    headings : int
        Number of directions, evenly spread; the first is north.
    """
    position = _hips_under(body, points, np.median(points[:, :2], axis=0))
    turns = 2.0 * np.pi * np.arange(headings) / headings
    up = np.array([0.0, 0.0, 1.0])
    return [hanging_pose(position, rotation_from_vector(turn * up)) for turn in turns]


def _hips_under(body: BodyModel, points: FloatArray, middle: FloatArray) -> FloatArray:
    """Hip midpoint (3,) of a body that stands at `middle` (2,) with its head at the cloud's top."""
    around = np.linalg.norm(points[:, :2] - middle, axis=1) < _AROUND
    heights = points[around, 2] if around.any() else points[:, 2]
    top = float(np.percentile(heights, _CROWN))
    return np.append(middle, top - crown_over_hips(body))


def crown_over_hips(body: BodyModel) -> float:
    """Height of the top of the head over the hip midpoint of an upright body, metres."""
    cones = body.cones
    head = np.flatnonzero((cones.part == HEAD) & cones.round_end)[0]
    crown = cones.origins[head, 2] + cones.height[head] + cones.r2[head]
    return float(body.skeleton.joints[HEAD, 2] + crown)
