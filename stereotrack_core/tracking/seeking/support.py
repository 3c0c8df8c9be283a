"""How much of the trunk is really seen: the sign by which a body that is partly away is told."""

from __future__ import annotations

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray
from stereotrack_core.body.model import BodyModel, placed_cones
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.skeleton import HEAD, TORSO
from stereotrack_core.body.surface import limbs_of_cones, nearest_on_surface
from stereotrack_core.depth.points import Volume

_NEAR = 0.10
"""Metres from the surface up to which data speak for the patch that they lie on."""

_ROWS, _COLUMNS = 3, 6
"""Patches of the torso along its axis and around it."""

_HEAD_COLUMNS = 4

_SIDE = 0.05
"""Metres from a side of the working volume."""

_TURNED = 0.25
"""Cosine between a patch's normal and the sight line from which a view sees it."""


def trunk_support(body: BodyModel, pose: Pose, points: FloatArray, cameras: FloatArray) -> float:
    """Share of those patches of torso and head which face a camera that have data.

    Parameters
    ----------
    body : BodyModel
    pose : Pose
    points : (N, 3) float64, world
    cameras : (V, 3) float64, world
        Optical centres.
    """
    frames = body.frames(pose)
    seen, expected = 0, 0
    feet = nearest_on_surface(points, placed_cones(body, frames), _NEAR)
    of_part = limbs_of_cones(body, feet.cone)
    for part, rows, columns in ((TORSO, _ROWS, _COLUMNS), (HEAD, 1, _HEAD_COLUMNS)):
        R, origin = frames.rotations[part], frames.origins[part]
        length = body.skeleton.lengths[part]
        local = (feet.foot[of_part == part] - origin) @ R
        row = np.clip(local[:, 2] / length * rows, 0, rows - 1).astype(int)
        turn = np.arctan2(local[:, 1], local[:, 0]) / (2.0 * np.pi) + 0.5
        column = np.clip(turn * columns, 0, columns - 1).astype(int)
        hit = np.zeros((rows, columns), dtype=np.bool_)
        hit[row, column] = True
        faces = _facing_cameras(rows, columns, length, R, origin, cameras)
        expected += int(np.count_nonzero(faces))
        seen += int(np.count_nonzero(hit & faces))
    return seen / max(expected, 1)


def share_at_sides(points: FloatArray, volume: Volume) -> float:
    """Share of points (N, 3) that lie within 50 mm of a side of the working volume.

    Somebody who is cut by a side has many there, somebody who only reaches out has few.
    """
    depth = np.minimum(points[:, :2] - volume.low[:2], volume.high[:2] - points[:, :2])
    return float(np.mean(depth.min(axis=1) < _SIDE)) if len(points) else 0.0


def _facing_cameras(
    rows: int,
    columns: int,
    length: float,
    rotation: FloatArray,
    origin: FloatArray,
    cameras: FloatArray,
) -> BoolArray:
    """Whether patches (rows, columns) are turned towards at least one camera."""
    turn = 2.0 * np.pi * ((np.arange(columns) + 0.5) / columns - 0.5)
    normal = np.stack([np.cos(turn), np.sin(turn), np.zeros(columns)], axis=1) @ rotation.T
    height = (np.arange(rows) + 0.5) / rows * length
    places = origin + height[:, None] * rotation[:, 2]
    sight = cameras[None] - places[:, None]
    sight /= np.linalg.norm(sight, axis=2, keepdims=True)
    cosine = np.einsum("rvi,ci->rcv", sight, normal)
    result: BoolArray = cosine.max(axis=2) > _TURNED
    return result
