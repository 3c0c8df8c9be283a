"""What things are made of and people wear, and a room as small triangles."""

from dataclasses import dataclass
from functools import cache

import numpy as np

from stereotrack_core.arrays import Float32Array, FloatArray, IntArray
from stereotrack_core.simulation.skeleton import BONE, Person, girth_scale, head_centre, rest_joints

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

_COLOURS: dict[str, tuple[Colour, Colour, Colour, Colour, Colour, Colour]] = {
    "P1": ((0.66, 0.47, 0.37), (0.13, 0.10, 0.08), (0.16, 0.30, 0.28), (0.36, 0.38, 0.40),
           (0.15, 0.15, 0.17), (0.22, 0.21, 0.20)),
    "P2": ((0.72, 0.54, 0.44), (0.30, 0.21, 0.12), (0.20, 0.30, 0.42), (0.42, 0.37, 0.30),
           (0.13, 0.17, 0.26), (0.20, 0.24, 0.32)),
    "P3": ((0.42, 0.29, 0.22), (0.07, 0.06, 0.06), (0.36, 0.20, 0.20), (0.44, 0.34, 0.20),
           (0.20, 0.18, 0.15), (0.28, 0.26, 0.22)),
    "P4": ((0.76, 0.58, 0.49), (0.42, 0.30, 0.15), (0.24, 0.18, 0.32), (0.33, 0.26, 0.28),
           (0.14, 0.14, 0.20), (0.20, 0.20, 0.28)),
}  # fmt: skip
"""Of skin and hair, and two each of shirt and trousers; in grey these differ by about a third, as
prints on cloth do."""


def worn(person: Person, clothes: str) -> tuple[Material, ...]:
    """Materials in the order skin, hair, shirt, sleeve, trousers, shoe."""
    skin, hair, shirt, prints, trousers, patches = _COLOURS[person.name]
    if clothes == "strong":
        upper = Material(STRONG, shirt, prints, 0.24, 0.01)
        lower = Material(STRONG, trousers, patches, 0.21, 0.01)
    elif clothes == "striped":
        upper = Material(STRIPED, prints, _darker(shirt), 0.085, 0.02)
        lower = Material(STRONG, trousers, patches, 0.21, 0.01)
    else:
        upper = Material(PLAIN, shirt, shirt, 1.0, 0.0)
        lower = Material(PLAIN, trousers, trousers, 1.0, 0.0)
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


_HALF = 4.5  # half the width of the room in metres; the room is square, and 3 m high
HEIGHT = 3.0
_DADO = 1.15  # up to here the walls are papered with a strong texture
_TILE = 0.06

_MATERIALS = {
    "floor": Material(TILES, (0.46, 0.43, 0.40), (0.24, 0.23, 0.22), 0.45, 0.30),
    "wall": Material(PLAIN, (0.46, 0.45, 0.41), (0.46, 0.45, 0.41), 1.0, 0.045),
    "paper": Material(STRONG, (0.48, 0.50, 0.48), (0.28, 0.34, 0.37), 0.30, 0.08),
    "ceiling": Material(PLAIN, (0.56, 0.56, 0.55), (0.56, 0.56, 0.55), 1.0, 0.02),
    "wood": Material(WOOD, (0.42, 0.29, 0.18), (0.30, 0.20, 0.12), 0.09, 0.12),
    "books": Material(STRONG, (0.62, 0.25, 0.18), (0.16, 0.26, 0.40), 0.10, 0.15),
    "cushion": Material(STRONG, (0.22, 0.40, 0.30), (0.50, 0.56, 0.38), 0.12, 0.15),
    "dark": Material(PLAIN, (0.15, 0.15, 0.17), (0.15, 0.15, 0.17), 1.0, 0.10),
    "picture": Material(STRONG, (0.75, 0.60, 0.30), (0.18, 0.25, 0.38), 0.35, 0.10),
}
ROOM_MATERIALS: tuple[Material, ...] = tuple(_MATERIALS.values())
_NUMBER = {name: number for number, name in enumerate(_MATERIALS)}


@dataclass(frozen=True, eq=False)
class Things:
    """Triangles (T, 3) that stand still; `stuff` (T,) are rows of :data:`ROOM_MATERIALS`."""

    vertices: FloatArray
    normals: FloatArray
    triangles: IntArray
    stuff: IntArray


_Triple = tuple[float, float, float]
_Sheet = tuple[FloatArray | _Triple, FloatArray | _Triple, FloatArray | _Triple, str]
"""A rectangle: corner, two edges (their cross product looks outwards), material."""

_Box = tuple[_Triple, _Triple, str]  # corner, size, material


@cache
def room(*, furnished: bool) -> Things:
    """The room, with or without furniture."""
    sheets = _walls()
    if furnished:
        for box in _FURNITURE:
            sheets += _box(*box)
    return _joined(sheets)


def _walls() -> list[_Sheet]:
    h, w = _HALF, 2 * _HALF
    sheets: list[_Sheet] = [
        ((-h, -h, 0), (w, 0, 0), (0, w, 0), "floor"),
        ((-h, -h, HEIGHT), (0, w, 0), (w, 0, 0), "ceiling"),
    ]
    for z, tall, name in ((0.0, _DADO, "paper"), (_DADO, HEIGHT - _DADO, "wall")):
        up = (0.0, 0.0, tall)
        sheets += [
            ((h, h, z), (-w, 0, 0), up, name),
            ((-h, -h, z), (w, 0, 0), up, name),
            ((h, -h, z), (0, w, 0), up, name),
            ((-h, h, z), (0, -w, 0), up, name),
        ]
    for x, wide in ((-2.4, 1.0), (1.3, 0.8)):
        sheets.append(((x, -h + 0.02, 1.45), (wide, 0, 0), (0, 0, 0.75), "picture"))
        sheets.append(((-x, h - 0.02, 1.45), (-wide, 0, 0), (0, 0, 0.75), "picture"))
        sheets.append(((h - 0.02, x, 1.45), (0, wide, 0), (0, 0, 0.75), "picture"))
        sheets.append(((-h + 0.02, -x, 1.45), (0, -wide, 0), (0, 0, 0.75), "picture"))
    return sheets


def _table(x: float, y: float) -> list[_Box]:
    corners = [(x + dx, y + dy, 0.0) for dx in (0.02, 1.32) for dy in (0.02, 0.72)]
    legs: list[_Box] = [(corner, (0.06, 0.06, 0.70), "wood") for corner in corners]
    return [*legs, ((x, y, 0.70), (1.40, 0.80, 0.04), "wood")]


def _shelf(x: float, y: float) -> list[_Box]:
    boxes: list[_Box] = [((x, y, z), (1.20, 0.34, 0.03), "wood") for z in (0.05, 0.5, 0.95, 1.4)]
    boxes += [((x + dx, y, 0.0), (0.03, 0.34, 1.43), "wood") for dx in (0.0, 1.17)]
    boxes += [((x + 0.08, y + 0.05, z + 0.03), (0.80, 0.22, 0.28), "books") for z in (0.05, 0.5)]
    boxes.append(((x + 0.25, y + 0.05, 0.98), (0.86, 0.22, 0.24), "books"))
    return boxes


def _chair(x: float, y: float) -> list[_Box]:
    legs: list[_Box] = [
        ((x + dx, y + dy, 0.0), (0.04, 0.04, 0.44), "dark") for dx in (0, 0.40) for dy in (0, 0.40)
    ]
    seat, back = ((0.44, 0.44, 0.05), "cushion"), ((0.44, 0.04, 0.45), "wood")
    return [*legs, ((x, y, 0.44), *seat), ((x, y, 0.49), *back)]


_FURNITURE: tuple[_Box, ...] = (
    *_table(-3.9, -3.6),
    ((-3.6, -3.4, 0.74), (0.36, 0.28, 0.22), "books"),
    *_shelf(1.6, 4.1),
    *_chair(2.55, -2.9),
    *_table(-3.6, 2.9),
    ((-3.0, 3.1, 0.74), (0.42, 0.30, 0.30), "dark"),
    ((3.75, -4.1, 0.0), (0.50, 0.50, 1.20), "cushion"),
    ((3.6, 2.2, 0.0), (0.70, 0.50, 0.85), "wood"),
    ((-4.3, -0.9, 0.0), (0.60, 1.30, 0.45), "cushion"),
)


def _box(corner: _Triple, size: _Triple, material: str) -> list[_Sheet]:
    c = np.array(corner)
    x, y, z = np.diag(size)
    faces = (
        (c + z, x, y), (c, y, x), (c, x, z), (c + x, y, z), (c + x + y, -x, z), (c + y, -y, z)
    )  # fmt: skip
    return [(*face, material) for face in faces]


def _joined(sheets: list[_Sheet]) -> Things:
    vertices, normals, triangles, stuff = [], [], [], []
    count = 0
    for corner, edge_1, edge_2, material in sheets:
        points, corners = _split(np.asarray(corner), np.asarray(edge_1), np.asarray(edge_2))
        normal = np.cross(edge_1, edge_2)
        vertices.append(points)
        normals.append(np.tile(normal / np.linalg.norm(normal), (len(points), 1)))
        triangles.append(corners + count)
        stuff.append(np.full(len(corners), _NUMBER[material]))
        count += len(points)
    return Things(*(np.concatenate(parts) for parts in (vertices, normals, triangles, stuff)))


def _split(
    corner: FloatArray, edge_1: FloatArray, edge_2: FloatArray
) -> tuple[FloatArray, IntArray]:
    """Vertices and triangles of a sheet cut into small squares."""
    m = max(1, int(np.ceil(np.linalg.norm(edge_1) / _TILE)))
    n = max(1, int(np.ceil(np.linalg.norm(edge_2) / _TILE)))
    u, v = np.meshgrid(np.arange(m + 1) / m, np.arange(n + 1) / n, indexing="ij")
    points = corner + u.reshape(-1, 1) * edge_1 + v.reshape(-1, 1) * edge_2
    i, j = np.meshgrid(np.arange(m), np.arange(n), indexing="ij")
    first = (i * (n + 1) + j).ravel()
    halves = (first, first + n + 1, first + 1), (first + n + 1, first + n + 2, first + 1)
    return points, np.concatenate([np.stack(half, axis=1) for half in halves])
