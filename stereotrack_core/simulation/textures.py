"""Solid textures: the brightness of a point of a thing, in the thing's own coordinates.

Both cameras of a pair, and all views, see the same texture because it belongs to the point
of the surface and not to the picture.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import Float32Array, FloatArray

PLAIN, STRONG, STRIPED, WOOD, TILES = range(5)
_LATTICE = 64


@dataclass(frozen=True)
class Material:
    """How a stuff looks.

    Attributes
    ----------
    kind : int
        One of the kinds of this module.
    first, second : (r, g, b)
        Reflectance from 0 to 1 of its two colours.
    scale : float
        Size in metres of the largest pattern: blots, period of stripes, tiles.
    grain : float
        Relative contrast of the fine grain that every stuff has.
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
    values: Float32Array = rng.uniform(-1, 1, (_LATTICE,) * 3).astype(np.float32)
    return values
