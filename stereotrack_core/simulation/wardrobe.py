"""What people wear, and where one piece of it ends."""

from __future__ import annotations

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.simulation.people import Person
from stereotrack_core.simulation.skeleton import BONE, head_centre, rest_joints
from stereotrack_core.simulation.textures import PLAIN, STRIPED, STRONG, Material

Colour = tuple[float, float, float]

_SKIN: dict[str, Colour] = {
    "P1": (0.66, 0.47, 0.37),
    "P2": (0.72, 0.54, 0.44),
    "P3": (0.42, 0.29, 0.22),
    "P4": (0.76, 0.58, 0.49),
}
_HAIR: dict[str, Colour] = {
    "P1": (0.13, 0.10, 0.08),
    "P2": (0.30, 0.21, 0.12),
    "P3": (0.07, 0.06, 0.06),
    "P4": (0.42, 0.30, 0.15),
}
_SHIRT: dict[str, tuple[Colour, Colour]] = {
    "P1": ((0.72, 0.70, 0.62), (0.12, 0.22, 0.36)),
    "P2": ((0.70, 0.55, 0.30), (0.16, 0.12, 0.24)),
    "P3": ((0.62, 0.72, 0.66), (0.30, 0.08, 0.10)),
    "P4": ((0.80, 0.72, 0.70), (0.28, 0.14, 0.34)),
}
_TROUSERS: dict[str, tuple[Colour, Colour]] = {
    "P1": ((0.40, 0.38, 0.34), (0.10, 0.10, 0.12)),
    "P2": ((0.38, 0.44, 0.54), (0.08, 0.12, 0.20)),
    "P3": ((0.45, 0.42, 0.36), (0.14, 0.12, 0.10)),
    "P4": ((0.36, 0.36, 0.42), (0.08, 0.08, 0.14)),
}


def worn(person: Person, clothes: str) -> tuple[Material, ...]:
    """Materials in the order skin, hair, shirt, sleeve, trousers, shoe."""
    skin, hair = _SKIN[person.name], _HAIR[person.name]
    shirt, trousers = _SHIRT[person.name], _TROUSERS[person.name]
    if clothes == "strong":
        upper = Material(STRONG, *shirt, 0.075, 0.20)
        lower = Material(STRONG, *trousers, 0.080, 0.20)
    elif clothes == "striped":
        upper = Material(STRIPED, *shirt, 0.055, 0.10)
        lower = Material(PLAIN, trousers[0], trousers[0], 1.0, 0.12)
    else:
        upper = Material(PLAIN, shirt[0], shirt[0], 1.0, 0.012)
        lower = Material(PLAIN, trousers[0], trousers[0], 1.0, 0.012)
    return (
        Material(PLAIN, skin, skin, 1.0, 0.05),
        Material(STRONG, hair, (0.5 * hair[0], 0.5 * hair[1], 0.5 * hair[2]), 0.03, 0.30),
        upper,
        upper,
        lower,
        Material(PLAIN, (0.10, 0.09, 0.09), (0.10, 0.09, 0.09), 1.0, 0.20),
    )


def borders(person: Person) -> FloatArray:
    """Where the clothes end, (6,) metres at rest, as the shading reads them."""
    joints = rest_joints(person)
    return np.array(
        [
            joints[BONE["neck"], 2] + 0.035,
            head_centre(person)[2],
            joints[BONE["hand_right"], 0] - 0.012,
            joints[BONE["upper_arm_right"], 0] + 0.005,
            joints[0, 2] + 0.10 * person.torso_length,
            person.ankle_height + 0.03,
        ]
    )
