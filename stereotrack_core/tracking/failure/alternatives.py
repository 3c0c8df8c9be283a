"""Whether an arm elsewhere would explain the pictures as well as the arm where it is."""

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.model import BodyModel, PlacedCones
from stereotrack_core.body.pose import Pose
from stereotrack_core.body.skeleton import FOREARMS, UPPER_ARMS
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.geometry.rotation import skew
from stereotrack_core.tracking.arm_search.arms import (
    LEFT,
    RIGHT,
    Arms,
    arm_of_pose,
    arm_shape,
    with_arm,
)
from stereotrack_core.tracking.arm_search.picture import SeenPicture, outline_cones, seen_pictures
from stereotrack_core.tracking.arm_search.score import anatomy_cost

_STEP = 5
_UNLIKE = 0.8  # pixels by which a disparity is off that counts half
_OFF = np.radians([60.0, 110.0])  # of the alternatives; an arm that is right has none among them
_AROUND = 4  # directions in which they lie, for each angle
_ALLOWED = 4.0  # cost of its anatomy by which an alternative may exceed the arm as it is


def elsewhere(cloud: Cloud, body: BodyModel, pose: Pose, own: FloatArray) -> FloatArray:
    """How much better (6,) than the arms as they are the best alternatives are; 0 for torso and
    head.

    For an upper arm the whole arm is turned by 60 and 110 degrees in four directions each, for a
    forearm it alone. The result is by how much less of the views' pictures disagrees, of
    alternatives that anatomy allows, over the limb's `own` area (6,), square metres.
    """
    result = np.zeros(len(LIMBS))
    pictures = seen_pictures(cloud, _STEP)
    frames = body.frames(pose)
    here = outline_cones(body, frames)
    for side in (LEFT, RIGHT):
        present, shape = arm_of_pose(frames, side), arm_shape(body, side)
        upper, fore = present.upper[0], present.fore[0]
        turned = _around(upper)
        carried = _carried(upper, turned, fore)
        still = np.broadcast_to(upper, (2 * _AROUND, 3))
        of_upper = Arms(turned, carried)
        of_fore = Arms(still, _around(fore))
        least = float(anatomy_cost(body, shape, present)[0]) + _ALLOWED
        for limb, arms, moved in (
            (UPPER_ARMS[side], of_upper, (UPPER_ARMS[side], FOREARMS[side])),
            (FOREARMS[side], of_fore, (FOREARMS[side],)),
        ):
            arms = arms[np.flatnonzero(anatomy_cost(body, shape, arms) < least).tolist()]
            if not len(arms):
                continue
            poses = with_arm(pose, side, arms.upper, arms.fore)
            gains = _gains(pictures, body, here, poses, moved)
            result[limb] = gains.max() / own[list(moved)].sum()
    return result


def _gains(
    pictures: tuple[SeenPicture, ...],
    body: BodyModel,
    here: PlacedCones,
    poses: Pose,
    moved: tuple[int, ...],
) -> FloatArray:
    """Square metres (K,), mean over views, by which less disagrees than with cones `here`."""
    chosen = np.isin(body.cones.part, moved)
    there = outline_cones(body, body.frames(poses))
    rest = here[~chosen]
    limbs = np.concatenate([here[None, chosen], there[:, chosen]])
    total = np.zeros(len(limbs))
    for seen in pictures:
        behind = seen.drawn(rest)
        nothing = np.zeros_like(behind)[None]
        unlike = seen.unlike_pairs(behind, seen.drawn_each(limbs), nothing, _UNLIKE)
        total += seen.area(poses.position[0]) * unlike[:, 0]
    gains: FloatArray = (total[0] - total[1:]) / len(pictures)
    return gains


def _around(direction: FloatArray) -> FloatArray:
    """Unit vectors (2 * _AROUND, 3) at two angles around a unit vector."""
    aside = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    aside /= np.linalg.norm(aside)
    other = np.cross(direction, aside)
    turns = 2.0 * np.pi * np.arange(_AROUND) / _AROUND
    found = []
    for k, off in enumerate(_OFF):
        ring = turns + k * np.pi / _AROUND
        out = np.outer(np.cos(ring), aside) + np.outer(np.sin(ring), other)
        found.append(np.cos(off) * direction + np.sin(off) * out)
    return np.vstack(found)


def _carried(a: FloatArray, b: FloatArray, vector: FloatArray) -> FloatArray:
    """Turn a vector (3,) as the smallest rotations turn a (3,) to b (K, 3), none opposite."""
    across = skew(np.cross(a, b))
    once = across @ vector
    twice = np.einsum("kij,kj->ki", across, once)
    return np.asarray(vector + once + twice / (1.0 + b @ a)[:, None])
