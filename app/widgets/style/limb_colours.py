"""One colour per limb, the same in views, scene, plots, lanes and tables.

The hues are those of Okabe and Ito, which eyes with a colour deficiency tell apart: the
person's left in blues, right in oranges, torso grey, head green.
"""

from __future__ import annotations

from types import MappingProxyType

from stereotrack_core.evaluation.limb_colours import LIMB_COLOURS

__all__ = ["EXTRA_COLOURS", "LANDMARK_LIMBS", "LIMB_COLOURS", "limb_rgb", "limb_words"]

EXTRA_COLOURS: MappingProxyType[str, str] = MappingProxyType({"unexplained %": "#CC79A7"})
"""Curves that are no angle of a limb and are drawn when asked for."""

LANDMARK_LIMBS: MappingProxyType[str, str] = MappingProxyType(
    {
        "left_shoulder": "left_upper_arm",
        "right_shoulder": "right_upper_arm",
        "left_elbow": "left_upper_arm",
        "right_elbow": "right_upper_arm",
        "left_hand": "left_forearm",
        "right_hand": "right_forearm",
        "head": "head",
        "left_hip": "torso",
        "right_hip": "torso",
    }
)
"""The limb whose colour a landmark is drawn in."""


def limb_rgb(limb: str) -> tuple[int, int, int]:
    """Red, green and blue of a limb, 0 to 255."""
    text = LIMB_COLOURS[limb]
    return int(text[1:3], 16), int(text[3:5], 16), int(text[5:7], 16)


def brief_limb_words(limb: str) -> str:
    """Return the limb's name for where there is little room, such as ``L upper arm``."""
    for whole, brief in (("left ", "L "), ("right ", "R "), ("unexplained", "unexpl.")):
        if limb_words(limb).startswith(whole):
            return limb_words(limb).replace(whole, brief, 1)
    return limb_words(limb)


def limb_words(limb: str) -> str:
    """Return the limb's name as a person reads it, such as ``left upper arm``."""
    return limb.replace("_", " ")
