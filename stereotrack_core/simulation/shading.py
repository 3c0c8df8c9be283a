"""Lambertian light on textured surfaces, and what a person wears where."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from stereotrack_core.arrays import Float32Array, FloatArray, IntArray
from stereotrack_core.compiled import compiled

_LAMP = np.array([0.38, 0.52, 0.764])
_SOFT_LAMP = np.array([-0.60, -0.48, 0.640])
_LAMP_STRENGTH, _SOFT_STRENGTH, _AMBIENT = 0.09, 0.08, 0.65
"""Directions towards two lamps, the second a half Lambert one, their strengths, and that of the
light from everywhere."""

_EXPOSURE = 370.0

SKIN, HAIR, SHIRT, SLEEVE, TROUSERS, SHOE = range(6)
"""Rows of a person's material table."""


@dataclass(frozen=True, eq=False)
class Stuff:
    """Materials at points: rows (N,) of a `table` (M, 9), and the coordinate across stripes."""

    table: FloatArray
    row: IntArray
    stripe: FloatArray


def clothing(table: FloatArray, marks: FloatArray, points: FloatArray) -> Stuff:
    """What a person wears at points (N, 3) at rest."""
    row = region(points, marks)
    return Stuff(table, row, np.where(row == SLEEVE, np.abs(points[:, 0]), points[:, 2]))


def region(points: FloatArray, marks: FloatArray) -> IntArray:
    """Rows (N,) of a person's materials at points (N, 3) at rest.

    `marks`: height of the collar, height of the hair line, reach of the cuffs, reach of the
    shoulder seams, height of the belt, height of the shoes, height below which nothing is
    arm, half width of the collar.
    """
    collar, hair_line, cuff, seam, belt, shoe, armpit, neck = marks
    x, y, z = points.T
    out, upper = np.abs(x), z > armpit
    head = (z > collar - 0.25 * np.maximum(0.0, y)) & ((out < neck) | (z > collar + 0.05))
    hair = z > hair_line + 0.9 * y + 0.02
    places = (
        upper & (out > cuff), upper & (out > seam), upper & head & hair, upper & head,
        z > belt, z > shoe,
    )  # fmt: skip
    return np.select(places, (SKIN, SLEEVE, HAIR, SKIN, SHIRT, TROUSERS), SHOE)


def shade(
    points: FloatArray,
    normals: FloatArray,
    stuff: Stuff,
    lattice: Float32Array,
    response: FloatArray,
) -> FloatArray:
    """Light (N, c) that a camera gets from points.

    Parameters
    ----------
    points : (N, 3); coordinates in which the textures live
    normals : (N, 3), world
    stuff : Stuff
    lattice : (64, 64, 64); noise of the textures
    response : (c, 3); the camera's channels from red, green, blue
    """
    colours = np.empty(points.shape)
    _reflectance(colours, stuff.table, stuff.row, stuff.stripe, lattice, points)
    bright = _brightness(normals)
    return np.stack([along(colours, channel) * bright for channel in response], axis=1)


def along(vectors: FloatArray, axis: FloatArray) -> FloatArray:
    """Scalar products (N,), summed in a fixed order: pictures are the same on all machines."""
    result: FloatArray = vectors[:, 0] * axis[0] + vectors[:, 1] * axis[1] + vectors[:, 2] * axis[2]
    return result


def _brightness(normals: FloatArray) -> FloatArray:
    length = np.maximum(np.sqrt(along(normals**2, np.ones(3))), 1e-9)
    strong = np.maximum(0.0, along(normals, _LAMP) / length)
    soft = 0.5 + 0.5 * (along(normals, _SOFT_LAMP) / length)
    result: FloatArray = _EXPOSURE * (_AMBIENT + _LAMP_STRENGTH * strong + _SOFT_STRENGTH * soft)
    return result


@compiled()
def _lattice_noise(lattice: Any, x: float, y: float, z: float) -> float:
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


@compiled()
def _reflectance(out: Any, table: Any, rows: Any, stripes: Any, lattice: Any, points: Any) -> None:
    """Write the colours (N, 3) of materials at points."""
    for n in range(points.shape[0]):
        x, y, z = points[n, 0], points[n, 1], points[n, 2]
        m = rows[n]
        share = _second_share(table[m, 0], table[m, 7], lattice, (x, y, z), stripes[n])
        grain = _lattice_noise(lattice, x * 70 + 7.7, y * 70 + 3.1, z * 70 + 1.9)
        grain += 0.6 * _lattice_noise(lattice, x * 21 + 1.3, y * 21 + 8.5, z * 21 + 4.7)
        factor = max(0.0, 1 + table[m, 8] * grain)
        for c in range(3):
            out[n, c] = (table[m, 1 + c] * (1 - share) + table[m, 4 + c] * share) * factor


@compiled()
def _second_share(kind: float, scale: float, lattice: Any, point: Any, stripe: float) -> float:
    """Share of a material's second colour; kinds as :mod:`materials` numbers them."""
    x, y, z = point
    if kind == 1:
        coarse = _lattice_noise(lattice, x / scale, y / scale, z / scale)
        s2 = 0.42 * scale
        middle = _lattice_noise(lattice, x / s2 + 17.3, y / s2 + 5.1, z / s2 + 29.7)
        s3 = 0.19 * scale
        fine = _lattice_noise(lattice, x / s3 + 41.9, y / s3 + 11.7, z / s3 + 3.3)
        return min(1.0, max(0.0, 0.5 + 1.1 * (0.6 * coarse + 0.7 * middle + 0.6 * fine)))
    if kind == 2:
        return min(1.0, max(0.0, 0.5 + 4.0 * math.sin(2 * math.pi * stripe / scale)))
    if kind == 3:
        rings = x / scale + 1.8 * _lattice_noise(lattice, 6 * x, 1.5 * y, 1.5 * z)
        return 0.5 + 0.5 * math.sin(6.2832 * rings)
    if kind == 4:
        u, v = x / scale - math.floor(x / scale), y / scale - math.floor(y / scale)
        w = z / scale - math.floor(z / scale)
        joint = min(min(u, 1 - u), min(v, 1 - v))
        joint = min(joint, max(min(w, 1 - w), 0.0)) if abs(z) > 1e-3 else joint
        return 1.0 if joint * scale < 0.006 else 0.0
    return 0.0
