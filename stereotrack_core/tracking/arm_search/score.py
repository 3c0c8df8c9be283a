"""What speaks for and against an arm (docs/method.md 4.9)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import PartFrames
from stereotrack_core.body.skeleton import TORSO
from stereotrack_core.depth.cloud import Cloud, ViewDepth
from stereotrack_core.geometry.rotation import angle_between
from stereotrack_core.geometry.segments import segment_distance
from stereotrack_core.tracking.arm_search.arms import LEFT, Arms, ArmShape
from stereotrack_core.tracking.arm_search.kernels import anatomy_costs, count_sight

_ALONG = np.linspace(0.0, 3.0, 11)[2:]
"""Nine places along the arm: 0 shoulder, 1 elbow, 2 wrist, 3 finger tip."""

_BEYOND_ELBOW = 2
"""The first of them that is beyond the elbow."""

_SEGMENT = np.minimum(_ALONG.astype(int), 2)
_T = _ALONG - _SEGMENT
_SHARES = np.eye(4)[_SEGMENT] * (1.0 - _T)[:, None] + np.eye(4)[_SEGMENT + 1] * _T[:, None]
"""Shares (9, 4) of the nodes in these places."""

SEE_THROUGH_PX, SUPPORT_PX = 1.3, 0.9
"""Pixels of disparity from which a view looks through a place, and up to which it supports it: a
little more than the matcher's errors."""

SEEN_THROUGH, UNSUPPORTED = 2.5, 1.5
"""Costs of a place that a view looks through, at most two views counting, and of one that no view
supports or hides; in data explained, as all of the search's costs."""

_FILLED, _ONLY_HIDDEN = 0.25, 0.75
"""Costs of a place inside a silhouette where no view has a range, and of one that all views have
something in front of: less, for nothing speaks against an arm there (docs/accuracy.md)."""

_UPPER, _FORE = (0, 1), (1, 3)
"""First and last node of an upper arm, and of a forearm with its hand."""

_UNKNOWN = np.zeros((0, 0), dtype=np.bool_)


@dataclass(frozen=True, eq=False)
class Scene:
    """What arms are scored against at one instant.

    Attributes
    ----------
    frames : PartFrames
        Of the present pose; proposals are in its torso's frame.
    body : BodyModel
    depths : tuple of ViewDepth
    """

    frames: PartFrames
    body: BodyModel
    depths: tuple[ViewDepth, ...]

    @staticmethod
    def of(cloud: Cloud, body: BodyModel, frames: PartFrames) -> Scene:
        """Scene of one cloud."""
        return Scene(frames, body, tuple(cloud.depths.values()))


def places_along(shape: ArmShape, arms: Arms) -> tuple[FloatArray, FloatArray]:
    """Nine places (K, 9, 3) along the axes of arms, torso's frame, and radii (9,) there."""
    of_segments = shape.radii[_SEGMENT]
    return _SHARES @ shape.nodes(arms), of_segments[:, 0] * (1.0 - _T) + of_segments[:, 1] * _T


def sight_cost(scene: Scene, shape: ArmShape, arms: Arms) -> FloatArray:
    """Cost (K,) of places where views look through the arm, or where no view supports it.

    Pixels without a range prove nothing by themselves; inside the silhouette they weakly support,
    outside of it they are looked through.
    """
    places, radii = places_along(shape, arms)
    world = places.reshape(-1, 3) @ scene.frames.rotations[TORSO].T + scene.frames.origins[TORSO]
    radius = np.tile(radii, len(arms))
    seen = np.zeros((len(world), 4), dtype=np.int64)
    for depth in scene.depths:
        g = depth.geometry
        pinhole = np.array([g.focal, g.c_x, g.c_y])
        scale = g.disparity_scale
        in_camera = g.world_from_depth.inverse().apply(world)
        see_through, support = SEE_THROUGH_PX / scale, SUPPORT_PX / scale
        silhouette = _UNKNOWN if depth.silhouette is None else depth.silhouette
        count_sight(
            in_camera, radius, depth.range_z, silhouette, pinhole, see_through, support, seen
        )
    through, supported, hidden, filled = seen.reshape(len(arms), -1, 4).transpose(2, 0, 1)
    unsupported = np.where(hidden > 0, _ONLY_HIDDEN, UNSUPPORTED)
    unsupported = np.where(filled > 0, _FILLED, unsupported)
    cost = SEEN_THROUGH * np.minimum(through, 2) + np.where(supported > 0, 0.0, unsupported)
    result: FloatArray = cost.sum(axis=1)
    return result


def anatomy_cost(scene: Scene, shape: ArmShape, arms: Arms) -> FloatArray:
    """Cost (K,) of elbows bent too far, arms inside the torso, and arms where arms cannot be."""
    cones = scene.body.cones
    places = _SHARES[_BEYOND_ELBOW:] @ shape.nodes(arms)
    in_cone = (places - cones.origins[0]) @ cones.rotations[0]
    cost = np.empty(len(arms))
    mirrored = -1.0 if shape.side == LEFT else 1.0
    anatomy_costs(arms.upper, arms.fore, mirrored, in_cone, cones.sizes[0], cost)
    return cost


def change_cost(predicted: Arms, arms: Arms) -> FloatArray:
    """Cost (K,) of the change against the predicted arm."""
    upper = np.degrees(angle_between(arms.upper, predicted.upper)) / 30.0
    fore = np.degrees(angle_between(arms.fore, predicted.fore)) / 40.0
    result: FloatArray = 2.0 * (np.log1p(upper**2) + np.log1p(fore**2))
    return result


def crossing_cost(left: FloatArray, right: FloatArray, least: float) -> FloatArray:
    """Cost (K, L) of pairs of arms that go through each other.

    Parameters
    ----------
    left, right : (K, 4, 3) and (L, 4, 3) float64, torso's frame
        Nodes of arms, see :meth:`ArmShape.nodes`.
    least : float, metres
        Least distance of the forearms' axes, see :mod:`residuals.collisions`; 0: none.
    """
    total: FloatArray = np.zeros((len(left), len(right)))
    if least <= 0.0:
        return total
    one, two = left[:, None], right[None]
    for (a, b), (c, d), room in ((_FORE, _FORE, 1.0), (_UPPER, _FORE, 2.0), (_FORE, _UPPER, 2.0)):
        apart = segment_distance(one[..., a, :], one[..., b, :], two[..., c, :], two[..., d, :])
        total += 3.0 * np.clip((room * least - apart) / 0.03, 0.0, 2.0)
    return total
