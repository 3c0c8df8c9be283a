"""Whether an arm elsewhere would explain the pictures as well as the arm where it is."""

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray
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
    joined,
    with_arm,
)
from stereotrack_core.tracking.arm_search.picture import SeenPicture, outline_cones, seen_pictures
from stereotrack_core.tracking.arm_search.score import anatomy_cost

_STEP = 5
_UNLIKE = 0.8  # pixels by which a disparity is off that counts half
_OFF = np.radians([60.0, 110.0])  # of the alternatives; an arm that is right has none among them
_AROUND = 4  # directions in which they lie, for each angle
_ALLOWED = 4.0  # cost of its anatomy by which an alternative may exceed the arm as it is
_TURNS = [
    2.0 * np.pi * np.arange(_AROUND) / _AROUND + k * np.pi / _AROUND for k in range(len(_OFF))
]
# The alternatives (2 * _AROUND, 1) along, and on two axes across the direction that they are for.
_ALONG = np.repeat(np.cos(_OFF), _AROUND)[:, None]
_OUT = np.repeat(np.sin(_OFF), _AROUND)[:, None]
_COSINE, _SINE = (np.concatenate([f(turn) for turn in _TURNS])[:, None] for f in (np.cos, np.sin))


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
        still = np.broadcast_to(upper, turned.shape)
        # The forearm turns with the upper arm, as the smallest rotations do that turn that.
        across = skew(np.cross(upper, turned))
        once = across @ fore
        twice = np.einsum("kij,kj->ki", across, once)
        carried = np.asarray(fore + once + twice / (1.0 + turned @ upper)[:, None])
        of_upper = Arms(turned, carried)
        every = joined(present, of_upper, Arms(still, _around(fore)))
        cost = anatomy_cost(body, shape, every)
        allowed = np.flatnonzero(cost < cost[0] + _ALLOWED)[1:]
        poses = with_arm(pose, side, every.upper[allowed], every.fore[allowed])
        there = outline_cones(body, body.frames(poses))
        arm = UPPER_ARMS[side], FOREARMS[side]
        for limb, moved, first in ((arm[0], arm, 1), (arm[1], arm[1:], 1 + len(turned))):
            tried = there[(allowed >= first) & (allowed < first + len(turned))]
            if len(tried):
                gains = _gains(
                    pictures, pose.position, np.isin(body.cones["part"], moved), here, tried
                )
                result[limb] = gains.max() / own[list(moved)].sum()
    return result


def _gains(
    pictures: tuple[SeenPicture, ...],
    place: FloatArray,
    moved: BoolArray,
    here: PlacedCones,
    there: PlacedCones,
) -> FloatArray:
    """Square metres (K,), mean over views, by which less disagrees with `moved` cones elsewhere."""
    limbs, total = np.concatenate([here[None, moved], there[:, moved]]), np.zeros(1 + len(there))
    nothing = here[None, :0]
    for seen in pictures:
        total += seen.area(place) * seen.unlike(here[~moved], limbs, nothing, _UNLIKE)[:, 0]
    gains: FloatArray = (total[0] - total[1:]) / len(pictures)
    return gains


def _around(direction: FloatArray) -> FloatArray:
    """Unit vectors (2 * _AROUND, 3) at two angles around a unit vector."""
    aside = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    aside /= np.linalg.norm(aside)
    other = np.cross(direction, aside)
    return np.asarray(_ALONG * direction + _OUT * (_COSINE * aside + _SINE * other))
