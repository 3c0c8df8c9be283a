"""Triangles into a depth buffer, light on textured surfaces, clothes, and shadows that people cast.

Vertices come projected by the true camera (distortion included), so that triangles of a few
pixels give the picture of the distorted lens; every pixel is sampled 2 x 2.

Shadows are computed on the surfaces of room and people, so that all cameras see the same: by a
perspective shadow map (Williams, "Casting curved shadows on curved surfaces", 1978) whose
edge widens with the distance from what casts it (Fernando, "Percentage-closer soft shadows", 2005).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from stereotrack_core.arrays import BoolArray, Float32Array, FloatArray, IntArray
from stereotrack_core.compiled import compiled
from stereotrack_core.simulation.rig import looking_at

SAMPLES = 2  # samples per pixel along each axis


def in_samples(pixels: FloatArray, origin: tuple[int, int] = (0, 0)) -> FloatArray:
    """Coordinates in samples of pixels (V, 2); `origin` is the pixel at the buffers' corner."""
    return np.asarray((pixels - np.asarray(origin) + 0.5) * SAMPLES - 0.5)


@dataclass(frozen=True, eq=False)
class Raster:
    """The nearest surface at each sample; `draw` adds to it."""

    depth: Float32Array  # (h, w); 1 / z of the nearest surface so far
    triangle: IntArray  # (h, w); number of the triangle seen, counted over all meshes, or -1
    weights: Float32Array
    """(h, w, 2); shares of the triangle's second and third corner, corrected for perspective."""

    @staticmethod
    def over(depth: Float32Array) -> Raster:
        """An empty raster that draws only what is nearer than `depth`, which it changes."""
        triangle: Any = np.full(depth.shape, -1, np.int32)
        return Raster(depth, triangle, np.zeros((*depth.shape, 2), np.float32))

    def draw(
        self, samples: FloatArray, nearness: FloatArray, triangles: IntArray, first: int = 0
    ) -> None:
        """Draw a mesh of triangles (T, 3), the first of this number, where it is nearer.

        `samples` (V, 2) as :func:`in_samples` makes them, NaN drops the triangle; `nearness` (V,)
        is 1 / z in the camera.
        """
        buffers = self.depth, self.triangle, self.weights
        _rasterise(buffers, samples, nearness, triangles, first)

    def seen(self, triangles: IntArray, first: int = 0) -> Samples:
        """The samples that show a mesh, once everything is drawn."""
        numbers = self.triangle - first
        where = np.nonzero((numbers >= 0) & (numbers < len(triangles)))
        triangle = numbers[where]
        second, third = self.weights[where].T
        shares = np.stack([1.0 - second.astype(np.float64) - third, second, third])
        return Samples(where, triangle, triangles[triangle], shares)


@dataclass(frozen=True, eq=False)
class Samples:
    """Samples (N) of a raster that show one mesh."""

    where: tuple[Any, ...]  # rows and columns, as an index into pictures
    triangle: IntArray  # (N,)
    corners: IntArray  # (N, 3); vertices of each triangle
    shares: FloatArray  # (3, N); of each corner in what is seen

    def of(self, values: FloatArray) -> FloatArray:
        """Interpolate values (V, C) of the vertices, (N, C)."""
        a, b, c = (s[:, None] * values[k] for s, k in zip(self.shares, self.corners.T, strict=True))
        return np.asarray(a + b + c)


@compiled()
def _rasterise(out_buffers: Any, samples: Any, nearness: Any, triangles: Any, first: int) -> None:
    depth, ids, weights = out_buffers
    height, width = depth.shape
    for t in range(triangles.shape[0]):
        i, j, k = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        ax, ay = samples[i, 0], samples[i, 1]
        bx, by = samples[j, 0], samples[j, 1]
        cx, cy = samples[k, 0], samples[k, 1]
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
                ids[y, x] = first + t
                weights[y, x, 0] = wb * nb / near
                weights[y, x, 1] = wc * nc / near


_LAMP = np.array([0.38, 0.52, 0.764])
_SOFT_LAMP = np.array([-0.60, -0.48, 0.640])
_LAMP_STRENGTH, _SOFT_STRENGTH, _AMBIENT = 0.09, 0.08, 0.65
"""Directions towards two lamps, the second a half Lambert one, their strengths, and that of the
light from everywhere."""

_EXPOSURE = 370.0

SKIN, HAIR, SHIRT, SLEEVE, TROUSERS, SHOE = range(6)  # rows of a person's material table


@dataclass(frozen=True, eq=False)
class Stuff:
    """Materials at points: rows (N,) of a `table` (M, 9), and the coordinate across stripes."""

    table: FloatArray
    row: IntArray
    stripe: FloatArray


def clothing(table: FloatArray, marks: FloatArray, points: FloatArray) -> Stuff:
    """What a person wears at points (N, 3) at rest.

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
    row = np.select(places, (SKIN, SLEEVE, HAIR, SKIN, SHIRT, TROUSERS), SHOE)
    return Stuff(table, row, np.where(row == SLEEVE, out, z))


def shade(
    points: FloatArray, normals: FloatArray, stuff: Stuff, noise: Float32Array, response: FloatArray
) -> FloatArray:
    """Light (N, c) that a camera gets from points (N, 3), where textures live, with world normals.

    `noise` (64, 64, 64) is that of the textures, `response` (c, 3) makes the camera's
    channels from red, green and blue.
    """
    colours = np.empty(points.shape)
    _reflectance(colours, stuff.table, stuff.row, stuff.stripe, noise, points)
    length = np.maximum(np.sqrt(along(normals**2, np.ones(3))), 1e-9)
    strong = np.maximum(0.0, along(normals, _LAMP) / length)
    soft = 0.5 + 0.5 * (along(normals, _SOFT_LAMP) / length)
    bright = np.asarray(_EXPOSURE * (_AMBIENT + _LAMP_STRENGTH * strong + _SOFT_STRENGTH * soft))
    return np.stack([along(colours, channel) * bright for channel in response], axis=1)


def along(vectors: FloatArray, axis: FloatArray) -> FloatArray:
    """Scalar products (N,), summed in a fixed order: pictures are the same on all machines."""
    return np.asarray(vectors[:, 0] * axis[0] + vectors[:, 1] * axis[1] + vectors[:, 2] * axis[2])


@compiled()
def _lattice_noise(lattice: Any, x: float, y: float, z: float) -> float:
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
    """Share of a material's second colour; kinds as :class:`.room.Material` numbers them."""
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


_LAMP_DISTANCE, _LAMP_HEIGHTS, _LAMP_RADIUS = 4.2, (1.9, 2.5), 0.05
"""Metres from the middle of the room, above the floor, and of the lamp itself."""

_MAP_SIZE, _MAP_FOCAL = 768, 307.0  # pixels of the shadow map; 1 cm at the person

_LOOK_AT_HEIGHT, _NEAREST = 0.9, 0.3
"""Metres: the height at which the lamp is aimed, and the least distance of what casts a shadow."""

_BIAS = 0.05  # metres by which a caster must be nearer to the lamp: nothing shades itself
_REACH = 21  # pixels (odd) of the map in which things may cast a soft edge on a point
_LAMP_STREAM = 634802890  # of the random numbers that place the lamp: the shipped demo is made so


@dataclass(frozen=True, eq=False)
class Lamp:
    """A lamp at the side, and the share of the light that comes from it."""

    share: float
    axes: FloatArray  # (4, 3): rotation from world to lamp, whose z is its axis; place of the lamp

    @staticmethod
    def of(share: float, seed: int) -> Lamp | None:
        """The lamp of a seed; None without a share."""
        if not share:
            return None
        rng = np.random.default_rng([seed, _LAMP_STREAM])
        angle, height = rng.uniform(0, 2 * np.pi), rng.uniform(*_LAMP_HEIGHTS)
        place = np.array([*(_LAMP_DISTANCE * np.array([np.cos(angle), np.sin(angle)])), height])
        axes = looking_at(place, np.array([0.0, 0.0, _LOOK_AT_HEIGHT]))
        return Lamp(share, np.vstack([axes, place]))

    def shadows(self, people: Iterable[tuple[IntArray, FloatArray]]) -> Shadows:
        """Shadows of people: triangles (T, 3) and vertices (V, 3), world, of each."""
        nearness = np.zeros((_MAP_SIZE, _MAP_SIZE), np.float32)
        for triangles, vertices in people:
            x, y, z = (self.axes[:3] @ (vertices - self.axes[3]).T).astype(np.float64)
            safe = np.maximum(z, _NEAREST)
            samples = np.column_stack([x, y]) / safe[:, None] * _MAP_FOCAL + (_MAP_SIZE - 1) / 2
            samples[z < _NEAREST] = np.nan
            Raster.over(nearness).draw(samples, 1.0 / safe, triangles)
        reached = np.asarray(cv2.dilate(nearness, np.ones((_REACH, _REACH), np.uint8)), np.float32)
        return Shadows(self, nearness, reached)


@dataclass(frozen=True, eq=False)
class Shadows:
    """The light of a lamp that people take away from surfaces in a frame."""

    lamp: Lamp
    nearness: Float32Array  # (S, S): 1 / z of the nearest person seen by the lamp, or 0
    reached: Float32Array  # (S, S): greatest `nearness` around each pixel

    def left_light(self, points: FloatArray, normals: FloatArray, is_person: bool) -> FloatArray:
        """Share of the light (N,) that is left at points with normals (N, 3), world."""
        away = points - self.lamp.axes[3]
        distance = np.sqrt(along(away**2, np.ones(3)))
        facing = np.clip(-5.0 * along(normals, away.T) / distance, 0.0, 1.0)
        hidden = self._hidden(away, facing > 0.0)
        # The lamp shines in the empty scene as well, so that the room's sides that are turned
        # away from it lose nothing; those of a person have no light of the lamp.
        lost = 1.0 - facing * (1.0 - hidden) if is_person else facing * hidden
        return np.asarray(1.0 - self.lamp.share * lost)

    def _hidden(self, away: FloatArray, lit: BoolArray) -> FloatArray:
        """Share of the lamp (N,) that people hide from places (N, 3) away from it, if lit."""
        hidden = np.zeros(len(away))
        x, y, z = (along(away, axis) for axis in self.lamp.axes[:3])
        safe = np.maximum(z, _NEAREST)
        middle = (_MAP_SIZE - 1) / 2
        places = np.stack([x / safe * _MAP_FOCAL + middle, y / safe * _MAP_FOCAL + middle, z])
        inside = (places[:2] >= 0.0).all(axis=0) & (places[:2] <= _MAP_SIZE - 1).all(axis=0)
        chosen = np.flatnonzero(lit & inside & (z >= _NEAREST))
        hidden[chosen] = _hidden_shares(places[:, chosen], self.nearness, self.reached)
        return hidden


@compiled()
def _hidden_shares(places: Any, nearness: Any, reached: Any) -> Any:
    """Hidden shares (N,) of the lamp at pixels and depths (3, N) of its map."""
    size = nearness.shape[0]
    shares = np.zeros(places.shape[1])
    for n in range(places.shape[1]):
        u, v, z = places[0, n], places[1, n], places[2, n]
        limit = 1.0 / (z - _BIAS)
        nearest = reached[int(v + 0.5), int(u + 0.5)]
        if nearest <= limit:
            continue
        spread = max(0.7, _MAP_FOCAL * _LAMP_RADIUS * (nearest - 1.0 / z)) / 3
        count = 0
        for row in range(-3, 4):
            for column in range(-3, 4):
                r = min(size - 1, max(0, int(v + spread * row + 0.5)))
                c = min(size - 1, max(0, int(u + spread * column + 0.5)))
                count += nearness[r, c] > limit
        shares[n] = count / 49.0
    return shares
