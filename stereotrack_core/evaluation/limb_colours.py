"""One colour per limb, the same in pictures, plots, tables and the workbench.

The hues are those of Okabe and Ito, which eyes with a colour deficiency tell apart: the person's
left in blues, right in oranges, torso grey, head green.
"""

from __future__ import annotations

from types import MappingProxyType

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
