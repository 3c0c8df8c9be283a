"""How points and directions on the body move with the error state, in closed form."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numba
import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray
from stereotrack_core.body.pose import PartFrames
from stereotrack_core.body.skeleton import PARENTS, PARTS

_PARENTS = np.array(PARENTS, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Columns:
    """Where each part's joint stands in the error state (see :mod:`body.manifold`).

    Attributes
    ----------
    n : int
        Dimension of the error state: 6 + 2 J.
    first : (P,) int64
        First of a part's two columns; -1 for parts whose joints are not in the state.
    """

    n: int
    first: IntArray


def columns_of(joints: tuple[int, ...]) -> Columns:
    """Columns of an error state with these joints."""
    first = np.full(len(PARTS), -1, dtype=np.int64)
    first[list(joints)] = 6 + 2 * np.arange(len(joints))
    return Columns(6 + 2 * len(joints), first)


def point_jacobian(
    points: FloatArray,
    directions: FloatArray,
    part: IntArray,
    frames: PartFrames,
    columns: Columns,
) -> FloatArray:
    """Derivatives (m, n) of n . p(x) for points that move rigidly with their parts.

    The torso turns about its origin by a left rotation vector, a limb about the x and y axes of
    its own frame: a turn about an axis a through o moves n . p by a . ((p - o) x n).

    Parameters
    ----------
    points, directions : (m, 3) float64, world
    part : (m,) int64
    frames : PartFrames
        Of one pose.
    columns : Columns
    """
    J = np.zeros((len(points), columns.n))
    _fill(
        np.ascontiguousarray(points),
        np.ascontiguousarray(directions),
        part,
        np.ascontiguousarray(frames.rotations),
        np.ascontiguousarray(frames.origins),
        _PARENTS,
        columns.first,
        J,
    )
    return J


def points_along(
    points: FloatArray, directions: FloatArray, part: IntArray, frames: PartFrames
) -> FloatArray:
    """Places n . p(x) of points on fixed directions, for stacked poses.

    Parameters
    ----------
    points : (m, 3) float64
        In the frames of their parts.
    directions : (m, 3) float64, world
    part : (m,) int64
    frames : PartFrames
        Of S poses.

    Returns
    -------
    (S, m) float64, metres
    """
    along = np.empty((len(frames.origins), len(part)))
    _project(
        np.ascontiguousarray(points),
        np.ascontiguousarray(directions),
        part,
        np.ascontiguousarray(frames.rotations),
        np.ascontiguousarray(frames.origins),
        along,
    )
    return along


@numba.njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def _project(
    points: Any, directions: Any, part: Any, rotations: Any, origins: Any, along: Any
) -> None:
    turned = np.empty(9)
    for i in range(points.shape[0]):
        p = part[i]
        for j in range(3):
            for k in range(3):
                turned[3 * j + k] = directions[i, j] * points[i, k]
        for s in range(rotations.shape[0]):
            total = 0.0
            for j in range(3):
                total += directions[i, j] * origins[s, p, j]
                for k in range(3):
                    total += turned[3 * j + k] * rotations[s, p, j, k]
            along[s, i] = total


@numba.njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def _fill(
    points: Any,
    directions: Any,
    part: Any,
    rotations: Any,
    origins: Any,
    parents: Any,
    first: Any,
    J: Any,
) -> None:
    for i in range(points.shape[0]):
        nx, ny, nz = directions[i, 0], directions[i, 1], directions[i, 2]
        J[i, 0], J[i, 1], J[i, 2] = nx, ny, nz
        p = part[i]
        while p >= 0:
            x, y = points[i, 0] - origins[p, 0], points[i, 1] - origins[p, 1]
            z = points[i, 2] - origins[p, 2]
            tx, ty, tz = y * nz - z * ny, z * nx - x * nz, x * ny - y * nx
            if p == 0:
                J[i, 3], J[i, 4], J[i, 5] = tx, ty, tz
            elif first[p] >= 0:
                for axis in range(2):
                    J[i, first[p] + axis] = (
                        tx * rotations[p, 0, axis]
                        + ty * rotations[p, 1, axis]
                        + tz * rotations[p, 2, axis]
                    )
            p = parents[p]
