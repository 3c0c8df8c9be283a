"""Light on what the rasteriser saw: Lambertian, with a strong lamp and a soft one."""

from __future__ import annotations

from typing import Any

import numpy as np

from stereotrack_core.simulation.compiled import compiled
from stereotrack_core.simulation.textures import reflectance

LIGHT = np.array(
    [
        [0.38, 0.52, 0.764, 0.58],
        [-0.60, -0.48, 0.640, 0.40],
    ]
)
"""Direction towards the lamp and its strength; the second one is soft (half Lambert)."""

AMBIENT = 0.22
EXPOSURE = 330.0

SKIN, HAIR, SHIRT, SLEEVE, TROUSERS, SHOE = range(6)
"""Rows of a person's material table."""


@compiled
def shade(
    ids: Any,
    weights: Any,
    first_id: int,
    triangles: Any,
    points: Any,
    normals: Any,
    stuff: Any,
    table: Any,
    marks: Any,
    lattice: Any,
    light: Any,
    response: Any,
    picture: Any,
) -> None:
    """Write the light (h, w, c) of all samples that show these triangles.

    Parameters
    ----------
    ids, weights, first_id, triangles
        As :func:`rasterise` has them.
    points : (V, 3) float64
        Coordinates of the vertices in which the textures live.
    normals : (V, 3) float64, world
    stuff : (T,) int64
        Material of a triangle; -1 asks the person's `marks`.
    table : (M, 9) float64
    marks : (6,) float64
        Borders of a person's clothes, see :func:`_region`; unused for things.
    lattice : (64, 64, 64) float32
    light : (2, 4) float64
    response : (c, 3) float64
        The camera's channels from red, green, blue.
    picture : (h, w, c) float32
    """
    colour = np.empty(3)
    for y in range(ids.shape[0]):
        for x in range(ids.shape[1]):
            t = ids[y, x] - first_id
            if t < 0 or t >= triangles.shape[0]:
                continue
            wb, wc = weights[y, x, 0], weights[y, x, 1]
            wa = 1.0 - wb - wc
            i, j, k = triangles[t, 0], triangles[t, 1], triangles[t, 2]
            px = wa * points[i, 0] + wb * points[j, 0] + wc * points[k, 0]
            py = wa * points[i, 1] + wb * points[j, 1] + wc * points[k, 1]
            pz = wa * points[i, 2] + wb * points[j, 2] + wc * points[k, 2]
            m = stuff[t]
            stripe = pz
            if m < 0:
                m = _region(px, py, pz, marks)
                if m == SLEEVE:
                    stripe = abs(px)
            reflectance(table, m, lattice, px, py, pz, stripe, colour)
            nx = wa * normals[i, 0] + wb * normals[j, 0] + wc * normals[k, 0]
            ny = wa * normals[i, 1] + wb * normals[j, 1] + wc * normals[k, 1]
            nz = wa * normals[i, 2] + wb * normals[j, 2] + wc * normals[k, 2]
            bright = _brightness(nx, ny, nz, light)
            for c in range(picture.shape[2]):
                value = 0.0
                for b in range(3):
                    value += response[c, b] * colour[b]
                picture[y, x, c] = value * bright


@compiled
def mark(
    ids: Any, weights: Any, first_id: int, triangles: Any, points: Any, marks: Any, stuff: Any
) -> None:
    """Write what a person wears at each sample that shows these triangles, (h, w) int8."""
    for y in range(ids.shape[0]):
        for x in range(ids.shape[1]):
            t = ids[y, x] - first_id
            if t < 0 or t >= triangles.shape[0]:
                continue
            wb, wc = weights[y, x, 0], weights[y, x, 1]
            i, j, k = triangles[t, 0], triangles[t, 1], triangles[t, 2]
            p = (1.0 - wb - wc) * points[i] + wb * points[j] + wc * points[k]
            stuff[y, x] = _region(p[0], p[1], p[2], marks)


@compiled
def _brightness(nx: float, ny: float, nz: float, light: Any) -> float:
    length = max(np.sqrt(nx * nx + ny * ny + nz * nz), 1e-9)
    strong = (nx * light[0, 0] + ny * light[0, 1] + nz * light[0, 2]) / length
    soft = (nx * light[1, 0] + ny * light[1, 1] + nz * light[1, 2]) / length
    total = AMBIENT + light[0, 3] * max(0.0, strong) + light[1, 3] * (0.5 + 0.5 * soft)
    return float(EXPOSURE * total)


@compiled
def _region(x: float, y: float, z: float, marks: Any) -> int:
    """Which stuff a point of a person at rest wears.

    `marks`: height of the collar, height of the hair line, reach of the cuffs, reach of the
    shoulder seams, height of the belt, height of the shoes.
    """
    out = abs(x)
    if out > marks[2]:
        return SKIN
    if out > marks[3]:
        return SLEEVE
    if z > marks[0] - 0.25 * max(0.0, y):
        if z > marks[1] + 0.9 * y + 0.02:
            return HAIR
        return SKIN
    if z > marks[4]:
        return SHIRT
    if z > marks[5]:
        return TROUSERS
    return SHOE
