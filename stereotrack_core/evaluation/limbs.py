"""Ends and colours of limbs."""

from types import MappingProxyType

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.limbs import LIMB_ENDS, LIMBS
from stereotrack_core.recording.landmarks import LANDMARKS

LIMB_COLOURS: MappingProxyType[str, str] = MappingProxyType(
    {
        "torso": "#8c8c8c",
        "head": "#009E73",
        "left_upper_arm": "#0072B2",
        "left_forearm": "#56B4E9",
        "right_upper_arm": "#D55E00",
        "right_forearm": "#E69F00",
    }
)
"""Colour of each limb as #rrggbb."""


def limb_bgr(limb: str) -> tuple[int, int, int]:
    """Blue, green and red of a limb, 0 to 255, as OpenCV has them; legs are a light grey."""
    text = LIMB_COLOURS.get(limb, "#b4b4b4")
    return int(text[5:7], 16), int(text[3:5], 16), int(text[1:3], 16)


def limb_ends(points: FloatArray) -> FloatArray:
    """Near and far ends (F, 6, 2, 3), world, metres, of the limbs of landmarks (F, 9, 3)."""
    result: FloatArray = np.empty((len(points), len(LIMBS), 2, 3))
    for i, limb in enumerate(LIMBS):
        for end, names in enumerate(LIMB_ENDS[limb]):
            own = [LANDMARKS.index(name) for name in names]
            result[:, i, end] = points[:, own].mean(axis=1)
    return result
