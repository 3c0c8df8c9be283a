"""Solid textures: the brightness of a point of a thing, in the thing's own coordinates.

Both cameras of a pair, and all views, see the same texture because it belongs to the point
of the surface and not to the picture.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from stereotrack_core.arrays import Float32Array, FloatArray
from stereotrack_core.simulation.compiled import compiled

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
    """Rows (M, 9) for :func:`reflectance`."""
    return np.array([material.row() for material in materials])


def noise_lattice(seed: int) -> Float32Array:
    """Random values in -1 to 1 on a cubic lattice that repeats, (64, 64, 64)."""
    rng = np.random.default_rng([seed, 64])
    values: Float32Array = rng.uniform(-1, 1, (_LATTICE,) * 3).astype(np.float32)
    return values


@compiled
def lattice_noise(lattice: Any, x: float, y: float, z: float) -> float:
    """Trilinear value of the lattice at a point in lattice units."""
    fx, fy, fz = math.floor(x), math.floor(y), math.floor(z)
    u, v, w = x - fx, y - fy, z - fz
    i, j, k = int(fx) & 63, int(fy) & 63, int(fz) & 63
    i1, j1, k1 = (i + 1) & 63, (j + 1) & 63, (k + 1) & 63
    a = lattice[i, j, k] * (1 - w) + lattice[i, j, k1] * w
    b = lattice[i, j1, k] * (1 - w) + lattice[i, j1, k1] * w
    c = lattice[i1, j, k] * (1 - w) + lattice[i1, j, k1] * w
    d = lattice[i1, j1, k] * (1 - w) + lattice[i1, j1, k1] * w
    return float((a * (1 - v) + b * v) * (1 - u) + (c * (1 - v) + d * v) * u)


@compiled
def reflectance(
    table: Any, m: int, lattice: Any, x: float, y: float, z: float, stripe: float, out: Any
) -> None:
    """Write the colour (3,) of material `m` at a point; `stripe` runs across the stripes."""
    kind = int(table[m, 0])
    scale = table[m, 7]
    share = 0.0
    if kind == 1:
        coarse = lattice_noise(lattice, x / scale, y / scale, z / scale)
        s2 = 0.42 * scale
        middle = lattice_noise(lattice, x / s2 + 17.3, y / s2 + 5.1, z / s2 + 29.7)
        s3 = 0.19 * scale
        fine = lattice_noise(lattice, x / s3 + 41.9, y / s3 + 11.7, z / s3 + 3.3)
        share = min(1.0, max(0.0, 0.5 + 1.1 * (0.6 * coarse + 0.7 * middle + 0.6 * fine)))
    elif kind == 2:
        wave = math.sin(2 * math.pi * stripe / scale)
        share = min(1.0, max(0.0, 0.5 + 4.0 * wave))
    elif kind == 3:
        rings = x / scale + 1.8 * lattice_noise(lattice, 6 * x, 1.5 * y, 1.5 * z)
        share = 0.5 + 0.5 * math.sin(6.2832 * rings)
    elif kind == 4:
        u, v = x / scale - math.floor(x / scale), y / scale - math.floor(y / scale)
        w = z / scale - math.floor(z / scale)
        joint = min(min(u, 1 - u), min(v, 1 - v))
        joint = min(joint, max(min(w, 1 - w), 0.0)) if abs(z) > 1e-3 else joint
        share = 1.0 if joint * scale < 0.006 else 0.0
    grain = lattice_noise(lattice, x * 70 + 7.7, y * 70 + 3.1, z * 70 + 1.9)
    grain += 0.6 * lattice_noise(lattice, x * 21 + 1.3, y * 21 + 8.5, z * 21 + 4.7)
    factor = max(0.0, 1 + table[m, 8] * grain)
    for c in range(3):
        out[c] = (table[m, 1 + c] * (1 - share) + table[m, 4 + c] * share) * factor
