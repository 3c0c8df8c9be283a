"""How one view's points lie to those of the other views: by how much they would have to be moved.

Iterated closest points, point to plane, over several instants at once. Only surfaces that face the
same way are laid onto each other, so that views of the front and of the back do not attract.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
import scipy

from stereotrack_core.arrays import FloatArray
from stereotrack_core.geometry.rotation import rotation_from_vector

_REACHES = (0.35, 0.35, 0.3, 0.25, 0.2, 0.15, 0.12, 0.1, 0.08, 0.06, 0.06, 0.06, 0.06, 0.06)
"""Metres within which points are laid onto each other, round by round."""

_SAME_WAY = 0.6
"""Cosine between normals from which two surfaces may be the same."""

_NEIGHBOURS = 12
_CLOSE = 0.02
"""Metres from a surface within which a point fits it."""

_STARTS = (0.0, -0.1, 0.1)
"""Logarithms of factors from which they are searched: points then lie within reach."""

_FEWEST = 150


@dataclass(frozen=True, eq=False)
class Surface:
    """Points (N, 3) and normals (N, 3) at one instant, world, metres."""

    points: FloatArray
    normals: FloatArray


Way: TypeAlias = Literal["range", "any"]
"""Error of a view: a factor on all its distances (range), or a rigid displacement (any)."""


@dataclass(frozen=True)
class CloudFit:
    """How a view's points would have to be moved to lie on those of the others."""

    way: Way
    amount: float
    """Factor of the distances, or metres for any other movement."""
    shift: float
    """Metres by which points move, median."""
    before: float
    """Share of the points that lie close to a surface of another view, of those near one after the
    move."""
    after: float
    """The same share after the move."""

    @property
    def gain(self) -> float:
        """By how much the share rises."""
        return self.after - self.before


def surface_of(points: FloatArray, eye: FloatArray) -> Surface:
    """Points (N, 3) with normals that look at a camera at `eye` (3,)."""
    if len(points) <= _NEIGHBOURS:
        return Surface(np.zeros((0, 3)), np.zeros((0, 3)))
    _, near = scipy.spatial.cKDTree(points).query(points, _NEIGHBOURS)
    patch = points[near] - points[near].mean(axis=1, keepdims=True)
    _, vectors = np.linalg.eigh(np.einsum("nki,nkj->nij", patch, patch))
    normals = vectors[:, :, 0]
    away = np.einsum("ij,ij->i", normals, points - eye) > 0
    normals[away] *= -1.0
    return Surface(points, normals)


def joined(surfaces: Sequence[Surface]) -> Surface:
    """All of them as one."""
    none = np.zeros((0, 3))
    return Surface(
        np.concatenate([none, *(one.points for one in surfaces)]),
        np.concatenate([none, *(one.normals for one in surfaces)]),
    )


def fit_clouds(
    own: Sequence[Surface], others: Sequence[Surface], eye: FloatArray, way: Way = "any"
) -> CloudFit | None:
    """The movement that lays a view's surfaces onto those of the others, instant by instant.

    `eye` (3,) is the view's camera. None where too little of both is near each other.
    """
    pairs = [(a, b) for a, b in zip(own, others, strict=True) if len(a.points) and len(b.points)]
    if not pairs:
        return None
    trees = [scipy.spatial.cKDTree(other.points) for _, other in pairs]
    starts = _STARTS if way == "range" else (0.0,)
    found = [_fitted(pairs, trees, eye, way, start) for start in starts]
    known = [one for one in found if one is not None]
    return max(known, key=lambda one: one[1])[0] if known else None


def _fitted(
    pairs: Sequence[tuple[Surface, Surface]],
    trees: Sequence[scipy.spatial.cKDTree],
    eye: FloatArray,
    way: Way,
    start: float,
) -> tuple[CloudFit, int] | None:
    """The fit that a search from a start ends with, and the points that lie close then."""
    every = np.concatenate([one.points for one, _ in pairs])
    about = every.mean(axis=0) if way == "any" else eye
    amount = np.full(1 if way == "range" else 6, start)
    moved = _affine(amount, about, way)
    for reach in _REACHES:
        rows, values = [], []
        for (one, other), tree in zip(pairs, trees, strict=True):
            points, normal, distance = _laid(one, other, tree, moved, reach)
            rows.append(_design(points - about, normal, way))
            values.append(distance)
        design, distances = np.concatenate(rows), np.concatenate(values)
        if len(design) < _FEWEST:
            return None
        step = _step(design, distances, 0.3 * reach)
        moved, amount = _affine(step, about, way) @ moved, amount + step
    close, count = _close(pairs, trees, moved)
    before, _ = _close(pairs, trees, _Affine(np.eye(3), np.zeros(3)))
    if count < _FEWEST:
        return None
    shift = float(np.median(np.linalg.norm(moved.apply(every) - every, axis=1)))
    size = float(np.exp(amount[0])) if way == "range" else shift
    return CloudFit(way, size, shift, before / count, close / count), close


@dataclass(frozen=True, eq=False)
class _Affine:
    """A matrix (3, 3) followed by a translation (3,)."""

    matrix: FloatArray
    translation: FloatArray

    def apply(self, points: FloatArray) -> FloatArray:
        return np.asarray(points @ self.matrix.T + self.translation)

    def __matmul__(self, other: _Affine) -> _Affine:
        return _Affine(self.matrix @ other.matrix, self.apply(other.translation))


def _design(arms: FloatArray, normal: FloatArray, way: Way) -> FloatArray:
    """Derivatives (N, K) of distances along normals; `arms` (N, 3) are points from the centre."""
    if way == "range":
        return np.asarray(np.einsum("ij,ij->i", arms, normal)[:, None])
    return np.hstack([np.cross(arms, normal), normal])


def _affine(step: FloatArray, about: FloatArray, way: Way) -> _Affine:
    """The movement of a step: a common factor, or a rigid one."""
    if way == "range":
        matrix, shift = np.exp(step[0]) * np.eye(3), np.zeros(3)
    else:
        matrix, shift = rotation_from_vector(step[:3]), step[3:]
    return _Affine(matrix, about - matrix @ about + shift)


def _laid(
    one: Surface,
    other: Surface,
    tree: scipy.spatial.cKDTree,
    moved: _Affine,
    reach: float,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Moved points, the normals of what they are laid onto, and the distances along them."""
    points = moved.apply(one.points)
    far, near = tree.query(points, distance_upper_bound=reach)
    found = np.flatnonzero(np.isfinite(far))
    normal = other.normals[near[found]]
    same = np.einsum("ij,ij->i", one.normals[found] @ moved.matrix.T, normal) > _SAME_WAY
    found, normal = found[same], normal[same]
    gap = other.points[near[found]] - points[found]
    return points[found], normal, np.einsum("ij,ij->i", gap, normal)


def _step(design: FloatArray, distances: FloatArray, scale: float) -> FloatArray:
    """Small change (K,) that takes the distances away, robustly (Geman-McClure)."""
    weight = 1.0 / np.square(1.0 + np.square(distances / scale))
    weighted = design * weight[:, None]
    normal = weighted.T @ design + 1e-6 * len(design) * np.eye(design.shape[1])
    return np.asarray(np.linalg.solve(normal, weighted.T @ distances), dtype=np.float64)


def _close(
    pairs: Sequence[tuple[Surface, Surface]],
    trees: Sequence[scipy.spatial.cKDTree],
    moved: _Affine,
) -> tuple[int, int]:
    """Points that lie close to a surface, and those that are near one."""
    close = near = 0
    for (one, other), tree in zip(pairs, trees, strict=True):
        _, _, distance = _laid(one, other, tree, moved, _REACHES[-1])
        close += int(np.count_nonzero(np.abs(distance) < _CLOSE))
        near += len(distance)
    return close, near
