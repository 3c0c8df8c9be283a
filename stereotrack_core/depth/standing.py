"""A person who stands still while the background is learned, told from the scene."""

from collections.abc import Callable, Iterable, Sequence

import cv2
import numpy as np

from stereotrack_core.arrays import BoolArray, Float32Array, FloatArray
from stereotrack_core.depth.cloud import DepthGeometry
from stereotrack_core.depth.points import Volume

_MOVES = 0.1  # share of the frames in which what moves stands in front of the learned background
_JUMP = 0.06  # metres between neighbouring pixels at which a surface ends
_AREA = (0.03, 1.6)  # square metres of a person that a camera sees, without what moves
_LARGEST = 2.3  # metres that a person measures at most, in any direction
_MOST_PLANES, _TRIES, _SAMPLED = 6, 300, 1500
_THICKNESS, _PLANE = 0.08, 2.0  # metres of noise around floor and walls, their least area in m^2
_OPENED, _TOUCHING = np.ones((3, 3), np.uint8), np.ones((7, 7), np.uint8)
_NEAR = 0.35  # metres of range between a trunk and the limbs that move in front of it or beside it
_LEAST_TOUCHING = 12  # pixels
_MOVED = 0.01  # square metres without which nothing moves: a hand has as much, noise less
_TALL, _LARGE = 0.5, 0.1  # least height, m, and area, m^2, of a person who does not move at all


def standing_person(
    geometry: DepthGeometry,
    volume: Volume,
    learned: Float32Array,
    in_front: Sequence[BoolArray],
    ranges: Callable[[BoolArray], Iterable[Float32Array]],
) -> BoolArray:
    """Pixels (H, W) of the learned background that are a person, parts of whom move.

    A surface of a person's size in the working volume that touches, in the image and in range, what
    moves in front of the background or beside it. A wall or a floor is larger, furniture is not
    touched as a rule.

    `learned` (H, W) are ranges, metres, NaN where unknown; `in_front` (H, W) is the foreground of
    each frame. `ranges` gives, frame by frame, the ranges (N,) in front of some pixels, else NaN:
    those of whole images would take gigabytes.
    """
    standing = np.zeros(learned.shape, dtype=bool)
    moving = _share(in_front) >= _MOVES
    if not moving.any():
        return standing
    with np.errstate(all="ignore"):
        moving_range = np.nanmedian(np.stack([*ranges(moving)]), axis=0)
    mover = np.full(learned.shape, np.nan, dtype=np.float32)
    mover[moving] = moving_range
    moving &= _inside(geometry, volume, mover)
    learned = np.where(_inside(geometry, volume, learned), learned, np.float32(np.nan))
    surfaces = (_surfaces(learned) & ~_planes(geometry, learned)).astype(np.uint8)
    _, labels = cv2.connectedComponents(surfaces, connectivity=4)
    touched = cv2.dilate(labels.astype(np.int16), _TOUCHING)
    for label in np.unique(touched[moving]):
        if label and _is_person(geometry, learned, labels == label, moving, mover):
            standing |= labels == label
    return _closed(standing, learned)


def moves(
    geometry: DepthGeometry,
    volume: Volume,
    in_front: Sequence[BoolArray],
    ranges: Callable[[BoolArray], Iterable[Float32Array]],
) -> bool:
    """Whether anything in the working volume moves; for the arrays see :func:`standing_person`."""
    moving = _share(in_front) >= _MOVES
    moving = cv2.morphologyEx(moving.astype(np.uint8), cv2.MORPH_OPEN, _OPENED).astype(bool)
    nearest = np.full(moving.shape, np.nan, dtype=np.float32)
    nearest[moving] = np.fmin.reduce([*ranges(moving)])
    z = nearest[_inside(geometry, volume, nearest)].astype(np.float64)
    return float(np.square(z / geometry.focal).sum()) > _MOVED


def _share(in_front: Sequence[BoolArray]) -> FloatArray:
    """Share (H, W) of the frames in which a pixel is foreground."""
    count = np.zeros(in_front[0].shape, np.int64)
    for front in in_front:
        count += front
    return count / len(in_front)


def still_person(
    geometry: DepthGeometry, volume: Volume, learned: Float32Array, up: FloatArray
) -> BoolArray:
    """Pixels (H, W) of the tallest surface of a person's size; for recordings without motion.

    `learned` (H, W) are ranges, metres, `up` (3,) a unit vector of the world. A wardrobe is larger
    and a chair is lower, but a plant may be taken.
    """
    learned = np.where(_inside(geometry, volume, learned), learned, np.float32(np.nan))
    surfaces = (_surfaces(learned) & ~_planes(geometry, learned)).astype(np.uint8)
    count, labels = cv2.connectedComponents(surfaces, connectivity=4)
    tallest, found = _TALL, np.zeros(learned.shape, dtype=bool)
    for label in range(1, count):
        surface = labels == label
        if np.count_nonzero(surface) < _LEAST_TOUCHING or not _of_a_size(
            geometry, learned, surface, _LARGE
        ):
            continue
        height = float(np.ptp(np.percentile(_points(geometry, learned, surface) @ up, [2, 98])))
        if height > tallest:
            tallest, found = height, surface
    return _closed(found, learned)


def _points(geometry: DepthGeometry, learned: Float32Array, surface: BoolArray) -> FloatArray:
    v, u = np.nonzero(surface)
    return geometry.points(u, v, learned[surface].astype(np.float64))


def _of_a_size(
    geometry: DepthGeometry, learned: Float32Array, surface: BoolArray, least: float
) -> bool:
    """Whether a surface of at least so many square metres is not larger than a person's."""
    z = learned[surface].astype(np.float64)
    if not least < float(np.square(z / geometry.focal).sum()) < _AREA[1]:
        return False
    ends = np.percentile(_points(geometry, learned, surface), [2, 98], axis=0)
    return float(np.linalg.norm(ends[1] - ends[0])) <= _LARGEST


def _inside(geometry: DepthGeometry, volume: Volume, ranges: Float32Array) -> BoolArray:
    """Pixels (H, W) whose points are in the volume."""
    inside = np.isfinite(ranges)
    v, u = np.nonzero(inside)
    inside[v, u] = volume.contains(geometry.points(u, v, ranges[v, u].astype(np.float64)))
    return inside


def _surfaces(learned: Float32Array) -> BoolArray:
    """Pixels (H, W) whose surface goes on to the next row and column."""
    steps = [np.abs(np.diff(learned, axis=axis, append=np.nan)) for axis in (0, 1)]
    result: BoolArray = (steps[0] < _JUMP) & (steps[1] < _JUMP)
    return result


def _planes(geometry: DepthGeometry, learned: Float32Array) -> BoolArray:
    """Pixels (H, W) of floor and walls by random sample consensus (doi:10.1145/358669.358692)."""
    v, u = np.nonzero(np.isfinite(learned))
    points = geometry.points(u, v, learned[v, u].astype(np.float64))
    area = np.square(learned[v, u].astype(np.float64) / geometry.focal)
    left, random = np.arange(len(points)), np.random.default_rng(0)
    found = np.zeros(learned.shape, dtype=bool)
    for _ in range(_MOST_PLANES):
        some = random.permutation(left)[:_SAMPLED]
        if len(some) < _SAMPLED:
            break  # too few pixels for a plane of that area
        normal, offset = _best_plane(points[some], area[some], random)
        on_it = np.abs(points[left] @ normal - offset) < _THICKNESS
        if area[left[on_it]].sum() < _PLANE:
            break
        found[v[left[on_it]], u[left[on_it]]] = True
        left = left[~on_it]
    return found


def _best_plane(
    points: FloatArray, area: FloatArray, random: np.random.Generator
) -> tuple[FloatArray, float]:
    """Normal (3,) and offset of the plane near which most of the area (N,) of points (N, 3) is."""
    three = points[random.integers(len(points), size=(_TRIES, 3))]
    normals = np.cross(three[:, 1] - three[:, 0], three[:, 2] - three[:, 0])
    length = np.linalg.norm(normals, axis=1)
    three, normals = three[length > 0], normals[length > 0] / length[length > 0, None]
    offsets = (normals * three[:, 0]).sum(axis=1)
    near = np.abs(points @ normals.T - offsets) < _THICKNESS
    best = int(np.argmax(area @ near))
    return normals[best], float(offsets[best])


def _is_person(
    geometry: DepthGeometry,
    learned: Float32Array,
    surface: BoolArray,
    moving: BoolArray,
    mover: Float32Array,
) -> bool:
    """Whether a surface is of a person's size and touches what moves."""
    if not _of_a_size(geometry, learned, surface, _AREA[0]):
        return False
    weight = cv2.blur(surface.astype(np.float32), _TOUCHING.shape)
    filled = cv2.blur(np.where(surface, learned, np.float32(0)), _TOUCHING.shape)
    beside = moving & (weight > 0)
    apart = np.abs(mover[beside] - filled[beside] / weight[beside])
    return int(np.count_nonzero(apart < _NEAR)) >= _LEAST_TOUCHING


def _closed(standing: BoolArray, learned: Float32Array) -> BoolArray:
    """With the borders and small gaps that its surfaces leave."""
    grown = cv2.morphologyEx(standing.astype(np.uint8), cv2.MORPH_CLOSE, _TOUCHING)
    result: BoolArray = (cv2.dilate(grown, np.ones((3, 3), np.uint8)) > 0) & np.isfinite(learned)
    return result
