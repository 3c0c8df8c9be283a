"""The tree of rigid parts and where their joints sit (section 2.5, figure 2.11)."""

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.proportions import Proportions

# Rigid parts: the limbs, the legs, which only take their data, and the shoulder girdle.
PARTS: tuple[str, ...] = (
    *LIMBS,
    *("left_thigh", "right_thigh", "left_shank", "right_shank"),
    *("left_clavicle", "right_clavicle"),
)
TORSO, HEAD, LEFT_UPPER_ARM, RIGHT_UPPER_ARM, LEFT_FOREARM, RIGHT_FOREARM = range(6)
LEFT_THIGH, RIGHT_THIGH, LEFT_SHANK, RIGHT_SHANK = range(6, 10)
LEFT_CLAVICLE, RIGHT_CLAVICLE = range(10, 12)
UPPER_ARMS = (LEFT_UPPER_ARM, RIGHT_UPPER_ARM)
FOREARMS = (LEFT_FOREARM, RIGHT_FOREARM)
ARM_PARTS: IntArray = np.array([*UPPER_ARMS, *FOREARMS])
THIGHS = (LEFT_THIGH, RIGHT_THIGH)
SHANKS = (LEFT_SHANK, RIGHT_SHANK)
CLAVICLES = (LEFT_CLAVICLE, RIGHT_CLAVICLE)
PARENTS: tuple[int, ...] = (-1, 0, 0, 0, 2, 3, 0, 0, 6, 7, 0, 0)  # that rotations refer to
# The part that carries each part's joint if not its parent. Clavicles carry the upper arms' joints
# and do not turn the arms, whose direction is stated against the torso.
CARRIERS: tuple[int, ...] = (-1, -1, *CLAVICLES, *[-1] * 8)
LEFT_PARTS = frozenset({LEFT_UPPER_ARM, LEFT_FOREARM, LEFT_THIGH, LEFT_SHANK, LEFT_CLAVICLE})
# (P,), of each part: shoulders are the torso's, legs are ``len(LIMBS)``.
LIMB_OF_PART: IntArray = np.array([*range(len(LIMBS)), *[len(LIMBS)] * 4, TORSO, TORSO])


def limb_of_part(part: int) -> str:
    """Name of the limb that a part counts for; empty for legs."""
    return LIMBS[limb] if (limb := int(LIMB_OF_PART[part])) < len(LIMBS) else ""


_CLAVICLE_BEGINS = 0.12  # where clavicles begin, as a share of half the shoulder width


@dataclass(frozen=True, eq=False)
class Skeleton:
    """Places of the joints.

    Frames: torso x to the person's right, y forward, z up, origin at the hip midpoint; a limb's z
    runs along the limb, away from the torso.
    """

    joints: FloatArray  # (P, 3), metres. In the parent's frame, while the shoulders rest
    lengths: FloatArray  # (P,), metres. To the next joint, or to the hand's or head's landmark
    proportions: Proportions


def skeleton(proportions: Proportions, leg_length_factor: float = 1.0) -> Skeleton:
    """Skeleton of a person with these proportions; legs differ from them by a factor."""
    p = proportions
    thigh, shank = leg_length_factor * p.thigh_length, leg_length_factor * p.shank_length
    half_shoulders, half_hips = 0.5 * p.shoulder_width, 0.5 * p.hip_width
    joints = np.array(
        [
            [0.0, 0.0, 0.0],
            [0.0, 0.0, p.torso_length],
            [-half_shoulders, 0.0, p.torso_length],
            [half_shoulders, 0.0, p.torso_length],
            [0.0, 0.0, p.upper_arm_length],
            [0.0, 0.0, p.upper_arm_length],
            [-half_hips, 0.0, 0.0],
            [half_hips, 0.0, 0.0],
            [0.0, 0.0, thigh],
            [0.0, 0.0, thigh],
            [-_CLAVICLE_BEGINS * half_shoulders, 0.0, p.torso_length],
            [_CLAVICLE_BEGINS * half_shoulders, 0.0, p.torso_length],
        ]
    )
    arms, legs = [p.upper_arm_length] * 2 + [p.elbow_to_hand] * 2, [thigh] * 2
    shanks = [shank] * 2
    clavicles = [(1.0 - _CLAVICLE_BEGINS) * half_shoulders] * 2
    lengths = np.array([p.torso_length, p.shoulder_to_head, *arms, *legs, *shanks, *clavicles])
    return Skeleton(joints, lengths, proportions)
