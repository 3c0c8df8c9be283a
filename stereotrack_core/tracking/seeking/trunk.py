"""What speaks for and against a place of the whole body, whatever its arms do."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.model import BodyModel, placed_cones
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.body.skeleton import (
    FOREARMS,
    HEAD,
    LEFT_SHANK,
    LEFT_THIGH,
    RIGHT_SHANK,
    RIGHT_THIGH,
    TORSO,
    UPPER_ARMS,
)
from stereotrack_core.body.surface import nearest_on_surface
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.tracking.search.kernels import count_sight

_SQUARED_SCALE = 0.06**2

_SEE_THROUGH_PX, _SUPPORT_PX = 1.3, 0.9
"""Pixels of disparity from which a view looks through a place, and up to which it supports it."""

_MAYBE_ARM = 0.5
"""Weight of data that an arm could explain."""

_SEEN_THROUGH, _NOTHING_THERE = 2.5, 1.5
"""Costs of a place inside the body that a view looks through, or that nothing is in front of."""


def unexplained_by_trunk(points: FloatArray, body: BodyModel, poses: Sequence[Pose]) -> FloatArray:
    """Mean (S,) of d^2 / (d^2 + 60 mm^2), d the distance of points from torso, head and legs.

    Points in reach of a shoulder count less, because arms may explain them.
    """
    rest = ~np.isin(body.cones.part, [*UPPER_ARMS, *FOREARMS])
    reach = sum(float(body.skeleton.lengths[part]) for part in (UPPER_ARMS[0], FOREARMS[0]))
    result = np.empty(len(poses))
    for k, pose in enumerate(poses):
        frames = body.frames(pose)
        placed = placed_cones(body, frames)[rest]
        squared = np.minimum(nearest_on_surface(points, placed, np.inf).distance, 1e3) ** 2
        unexplained = squared / (squared + _SQUARED_SCALE)
        off = [np.linalg.norm(points - frames.origins[part], axis=1) for part in UPPER_ARMS]
        result[k] = np.mean(np.where(np.minimum(*off) < reach, _MAYBE_ARM, 1.0) * unexplained)
    return result


def trunk_sight_cost(cloud: Cloud, body: BodyModel, poses: Sequence[Pose]) -> FloatArray:
    """Cost (S,) of places inside torso, head and legs where views see that nobody is."""
    places = np.stack([_places(body, body.frames(pose)) for pose in poses])
    through, supported, hidden, filled = sight_of(cloud, places.reshape(-1, 3)).T
    nothing = (supported + hidden + filled == 0) & (through == 0)
    cost = _SEEN_THROUGH * np.minimum(through, 2) + _NOTHING_THERE * nothing
    result: FloatArray = cost.reshape(len(poses), -1).sum(axis=1)
    return result


def sight_of(cloud: Cloud, places: FloatArray) -> IntArray:
    """How many views look through, support, hide or have no range at each place (M, 4).

    See :func:`count_sight`.
    """
    seen = np.zeros((len(places), 4), dtype=np.int64)
    nothing = np.zeros((0, 0), dtype=np.bool_)
    for depth in cloud.depths.values():
        g = depth.geometry
        pinhole = np.array([g.focal, g.c_x, g.c_y])
        scale = g.disparity_scale
        in_camera = g.world_from_depth.inverse().apply(places)
        silhouette = nothing if depth.silhouette is None else depth.silhouette
        count_sight(
            in_camera,
            np.zeros(len(places)),
            depth.range_z,
            silhouette,
            pinhole,
            _SEE_THROUGH_PX / scale,
            _SUPPORT_PX / scale,
            seen,
        )
    return seen


def _places(body: BodyModel, frames: PartFrames) -> FloatArray:
    """Places (M, 3), world, deep inside torso, head and legs."""
    length, half = body.skeleton.lengths, 0.35 * body.skeleton.proportions.shoulder_width
    in_torso = np.array([[x, 0.0, z] for z in (0.15, 0.5, 0.85) for x in (-half, 0.0, half)])
    in_torso *= [1.0, 1.0, length[TORSO]]
    along = [(HEAD, 0.5), (HEAD, 1.0)]
    along += [(part, t) for part in (LEFT_THIGH, RIGHT_THIGH) for t in (0.4, 0.9)]
    along += [(part, t) for part in (LEFT_SHANK, RIGHT_SHANK) for t in (0.5,)]
    parts = np.array([part for part, _ in along])
    reach = np.array([t * length[part] for part, t in along])
    on_limbs = frames.origins[parts] + reach[:, None] * frames.rotations[parts, :, 2]
    trunk = in_torso @ frames.rotations[TORSO].T + frames.origins[TORSO]
    return np.concatenate([trunk, on_limbs])
