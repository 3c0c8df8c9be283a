"""Triangles into a depth buffer, and Lambertian light on what is seen of them.

Vertices come projected by the true camera (distortion included), so that triangles of a few
pixels give the picture of the distorted lens; every pixel is sampled 2 x 2.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stereotrack_core.compiled import compiled

SAMPLES = 2
"""Samples per pixel along each axis."""


@compiled()
def rasterise(
    pixels: Any,
    nearness: Any,
    triangles: Any,
    first_id: int,
    origin_x: int,
    origin_y: int,
    depth: Any,
    ids: Any,
    weights: Any,
) -> None:
    """Draw triangles where they are nearer than what is there.

    Parameters
    ----------
    pixels : (V, 2); pixel coordinates of the whole image; NaN drops the triangle
    nearness : (V,); 1 / z in the camera
    triangles : (T, 3)
    first_id : number of the first triangle in `ids`
    origin_x, origin_y : pixel of the whole image at the corner of the buffers
    depth : (h, w); 1 / z of the nearest surface so far, per sample
    ids : (h, w); number of the triangle seen there
    weights : (h, w, 2); shares of the second and third corner, corrected for perspective
    """
    height, width = depth.shape
    for t in range(triangles.shape[0]):
        i, j, k = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        ax, ay = _sample(pixels[i, 0], origin_x), _sample(pixels[i, 1], origin_y)
        bx, by = _sample(pixels[j, 0], origin_x), _sample(pixels[j, 1], origin_y)
        cx, cy = _sample(pixels[k, 0], origin_x), _sample(pixels[k, 1], origin_y)
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if not abs(area) > 1e-12:
            continue
        left = max(0, int(min(ax, bx, cx)))
        right = min(width - 1, int(max(ax, bx, cx)) + 1)
        top = max(0, int(min(ay, by, cy)))
        bottom = min(height - 1, int(max(ay, by, cy)) + 1)
        na, nb, nc = nearness[i], nearness[j], nearness[k]
        for y in range(top, bottom + 1):
            for x in range(left, right + 1):
                wb = ((x - ax) * (cy - ay) - (y - ay) * (cx - ax)) / area
                wc = ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / area
                wa = 1.0 - wb - wc
                if wa < -1e-9 or wb < -1e-9 or wc < -1e-9:
                    continue
                near = wa * na + wb * nb + wc * nc
                if near <= depth[y, x]:
                    continue
                depth[y, x] = near
                ids[y, x] = first_id + t
                weights[y, x, 0] = wb * nb / near
                weights[y, x, 1] = wc * nc / near


@compiled()
def _sample(pixel: float, origin: int) -> float:
    """Coordinate in samples of a pixel coordinate; sample centres are whole numbers."""
    return (pixel - origin + 0.5) * SAMPLES - 0.5


LIGHT = np.array(
    [
        [0.38, 0.52, 0.764, 0.09],
        [-0.60, -0.48, 0.640, 0.08],
        [0.0, 0.0, 0.0, 0.65],
    ]
)
"""Direction towards a lamp and its strength: a lamp, a soft one (half Lambert), and light from
everywhere."""

_EXPOSURE = 370.0

SKIN, HAIR, SHIRT, SLEEVE, TROUSERS, SHOE = range(6)
"""Rows of a person's material table."""


@compiled()
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
    ids, weights, first_id, triangles : as :func:`rasterise` has them
    points : (V, 3); coordinates of the vertices in which the textures live
    normals : (V, 3), world
    stuff : (T,); material of a triangle; -1 asks the person's `marks`
    table : (M, 9)
    marks : (8,); borders of a person's clothes, see :func:`_region`; unused for things
    lattice : (64, 64, 64)
    light : (3, 4)
    response : (c, 3); the camera's channels from red, green, blue
    picture : (h, w, c)
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


@compiled()
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


@compiled()
def _brightness(nx: float, ny: float, nz: float, light: Any) -> float:
    length = max(np.sqrt(nx * nx + ny * ny + nz * nz), 1e-9)
    strong = (nx * light[0, 0] + ny * light[0, 1] + nz * light[0, 2]) / length
    soft = (nx * light[1, 0] + ny * light[1, 1] + nz * light[1, 2]) / length
    total = light[2, 3] + light[0, 3] * max(0.0, strong) + light[1, 3] * (0.5 + 0.5 * soft)
    return float(_EXPOSURE * total)


@compiled()
def _region(x: float, y: float, z: float, marks: Any) -> int:
    """Which stuff a point of a person at rest wears.

    `marks`: height of the collar, height of the hair line, reach of the cuffs, reach of the
    shoulder seams, height of the belt, height of the shoes, height below which nothing is
    arm, half width of the collar.
    """
    out = abs(x)
    if z > marks[6]:
        if out > marks[2]:
            return SKIN
        if out > marks[3]:
            return SLEEVE
        if z > marks[0] - 0.25 * max(0.0, y) and (out < marks[7] or z > marks[0] + 0.05):
            return HAIR if z > marks[1] + 0.9 * y + 0.02 else SKIN
    if z > marks[4]:
        return SHIRT
    if z > marks[5]:
        return TROUSERS
    return SHOE


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
def reflectance(
    table: Any, m: int, lattice: Any, x: float, y: float, z: float, stripe: float, out: Any
) -> None:
    """Write the colour (3,) of material `m` at a point; `stripe` runs across the stripes."""
    kind = int(table[m, 0])
    scale = table[m, 7]
    share = 0.0
    if kind == 1:
        coarse = _lattice_noise(lattice, x / scale, y / scale, z / scale)
        s2 = 0.42 * scale
        middle = _lattice_noise(lattice, x / s2 + 17.3, y / s2 + 5.1, z / s2 + 29.7)
        s3 = 0.19 * scale
        fine = _lattice_noise(lattice, x / s3 + 41.9, y / s3 + 11.7, z / s3 + 3.3)
        share = 0.5 + 1.1 * (0.6 * coarse + 0.7 * middle + 0.6 * fine)
        share = min(1.0, max(0.0, share))
    elif kind == 2:
        wave = math.sin(2 * math.pi * stripe / scale)
        share = min(1.0, max(0.0, 0.5 + 4.0 * wave))
    elif kind == 3:
        rings = x / scale + 1.8 * _lattice_noise(lattice, 6 * x, 1.5 * y, 1.5 * z)
        share = 0.5 + 0.5 * math.sin(6.2832 * rings)
    elif kind == 4:
        u, v = x / scale - math.floor(x / scale), y / scale - math.floor(y / scale)
        w = z / scale - math.floor(z / scale)
        joint = min(min(u, 1 - u), min(v, 1 - v))
        joint = min(joint, max(min(w, 1 - w), 0.0)) if abs(z) > 1e-3 else joint
        share = 1.0 if joint * scale < 0.006 else 0.0
    grain = _lattice_noise(lattice, x * 70 + 7.7, y * 70 + 3.1, z * 70 + 1.9)
    grain += 0.6 * _lattice_noise(lattice, x * 21 + 1.3, y * 21 + 8.5, z * 21 + 4.7)
    factor = max(0.0, 1 + table[m, 8] * grain)
    for c in range(3):
        out[c] = (table[m, 1 + c] * (1 - share) + table[m, 4 + c] * share) * factor
