"""Parameters of the outline, which is not where the clouds' surface is."""

from dataclasses import dataclass

from stereotrack_core.parameters import ParameterGroup, parameter

_GROUP = "Body contour"


def _margin(what: str) -> float:
    text = f"Distance of the contour from the surface, outwards: {what}."
    margin: float = parameter(-0.008, text, group=_GROUP, unit="m", minimum=-0.1, maximum=0.1)
    return margin


@dataclass(frozen=True)
class OutlineParameters(ParameterGroup):
    """Margins between the surface that clouds show and the outline in the pictures."""

    outline_torso_side: float = _margin("torso, lateral")
    outline_torso_front: float = _margin("torso, front and back")
    outline_shoulder_top: float = _margin("shoulders, top")
    outline_shoulder_front: float = _margin("shoulders, front and back")
    outline_jaw_side: float = _margin("lower head, lateral")
    outline_jaw_front: float = _margin("lower head, front and back")
    outline_head_side: float = _margin("upper head, lateral")
    outline_head_front: float = _margin("upper head, front and back")
    outline_upper_arm: float = _margin("upper arms")
    outline_forearm: float = _margin("forearms")
    outline_hand: float = _margin("hands")
