"""The limbs that errors, colours and confidences are stated for."""

from collections.abc import Mapping
from types import MappingProxyType

# The order of every array over limbs; left and right are the person's own.
LIMBS: tuple[str, ...] = (
    "torso",
    "head",
    "left_upper_arm",
    "right_upper_arm",
    "left_forearm",
    "right_forearm",
)
# Landmarks at a limb's near and far end; of two, the middle.
LIMB_ENDS: Mapping[str, tuple[tuple[str, ...], tuple[str, ...]]] = MappingProxyType(
    {
        "torso": (("left_hip", "right_hip"), ("left_shoulder", "right_shoulder")),
        "head": (("left_shoulder", "right_shoulder"), ("head",)),
        "left_upper_arm": (("left_shoulder",), ("left_elbow",)),
        "right_upper_arm": (("right_shoulder",), ("right_elbow",)),
        "left_forearm": (("left_elbow",), ("left_hand",)),
        "right_forearm": (("right_elbow",), ("right_hand",)),
    }
)
