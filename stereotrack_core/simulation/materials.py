"""What things are made of and people wear: solid textures in a thing's own coordinates.

Both cameras of a pair, and all views, see the same texture because it belongs to the point
of the surface and not to the picture.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import Float32Array, FloatArray
from stereotrack_core.simulation.people import Person, girth_scale
from stereotrack_core.simulation.skeleton import BONE, head_centre, rest_joints

PLAIN, STRONG, STRIPED, WOOD, TILES = range(5)
_LATTICE = 64


@dataclass(frozen=True)
class Material:
    """How a stuff looks: one of this module's kinds in two colours (r, g, b), reflectances 0 to 1.

    `scale` is the size in metres of the largest pattern (blots, period of stripes, tiles), `grain`
    the relative contrast of the fine grain that every stuff has.
    """

    kind: int
    first: tuple[float, float, float]
    second: tuple[float, float, float]
    scale: float
    grain: float

    def row(self) -> list[float]:
        """The numbers that the shading reads."""
        return [float(self.kind), *self.first, *self.second, self.scale, self.grain]


def material_table(materials: tuple[Material, ...]) -> FloatArray:
    """Rows (M, 9) for :func:`shading.reflectance`."""
    return np.array([material.row() for material in materials])


def noise_lattice(seed: int) -> Float32Array:
    """Random values in -1 to 1 on a cubic lattice that repeats, (64, 64, 64)."""
    rng = np.random.default_rng([seed, 64])
    return rng.uniform(-1, 1, (_LATTICE,) * 3).astype(np.float32)


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
    "P1": ((0.16, 0.30, 0.28), (0.36, 0.38, 0.40)),
    "P2": ((0.20, 0.30, 0.42), (0.42, 0.37, 0.30)),
    "P3": ((0.36, 0.20, 0.20), (0.44, 0.34, 0.20)),
    "P4": ((0.24, 0.18, 0.32), (0.33, 0.26, 0.28)),
}
_TROUSERS: dict[str, tuple[Colour, Colour]] = {
    "P1": ((0.15, 0.15, 0.17), (0.22, 0.21, 0.20)),
    "P2": ((0.13, 0.17, 0.26), (0.20, 0.24, 0.32)),
    "P3": ((0.20, 0.18, 0.15), (0.28, 0.26, 0.22)),
    "P4": ((0.14, 0.14, 0.20), (0.20, 0.20, 0.28)),
}
"""Two colours each; in grey they differ by about a third, as prints on cloth do."""


def worn(person: Person, clothes: str) -> tuple[Material, ...]:
    """Materials in the order skin, hair, shirt, sleeve, trousers, shoe."""
    skin, hair = _SKIN[person.name], _HAIR[person.name]
    shirt, trousers = _SHIRT[person.name], _TROUSERS[person.name]
    if clothes == "strong":
        upper = Material(STRONG, *shirt, 0.24, 0.01)
        lower = Material(STRONG, *trousers, 0.21, 0.01)
    elif clothes == "striped":
        upper = Material(STRIPED, shirt[1], _darker(shirt[0]), 0.085, 0.02)
        lower = Material(STRONG, *trousers, 0.21, 0.01)
    else:
        upper = Material(PLAIN, shirt[0], shirt[0], 1.0, 0.0)
        lower = Material(PLAIN, trousers[0], trousers[0], 1.0, 0.0)
    return (
        Material(PLAIN, skin, skin, 1.0, 0.05),
        Material(STRONG, hair, _darker(hair), 0.03, 0.20),
        upper,
        upper,
        lower,
        Material(PLAIN, (0.10, 0.09, 0.09), (0.10, 0.09, 0.09), 1.0, 0.20),
    )


def _darker(colour: Colour) -> Colour:
    red, green, blue = colour
    return 0.5 * red, 0.5 * green, 0.5 * blue


def borders(person: Person) -> FloatArray:
    """Where the clothes end, (8,) metres at rest, as the shading reads them."""
    joints = rest_joints(person)
    return np.array(
        [
            joints[BONE["neck"], 2] + 0.035,
            head_centre(person)[2],
            joints[BONE["hand_right"], 0] - 0.012,
            joints[BONE["upper_arm_right"], 0] + 0.005,
            joints[0, 2] + 0.10 * person.torso_length,
            person.ankle_height + 0.03,
            joints[BONE["upper_arm_right"], 2] - 0.16,
            0.062 * girth_scale(person),
        ]
    )
