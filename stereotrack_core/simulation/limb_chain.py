"""Two links that reach for a point: arms and legs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray

_STRETCH = 0.99985


@dataclass(frozen=True, eq=False)
class TwoLinks:
    """Directions of two links and the angle between them.

    Attributes
    ----------
    first, second : (3,) unit vectors
    hinge : (3,) unit vector
        The joint turns `first` towards `second` about it.
    flexion : float
        Angle between the links in radians.
    """

    first: FloatArray
    second: FloatArray
    hinge: FloatArray
    flexion: float

    @property
    def first_frame(self) -> FloatArray:
        """Columns: the first link, the hinge, and what completes them, (3, 3)."""
        return _frame(self.first, self.hinge)

    @property
    def second_frame(self) -> FloatArray:
        """Columns: the second link, the hinge, and what completes them, (3, 3)."""
        return _frame(self.second, self.hinge)


def two_links(target: FloatArray, length_1: float, length_2: float, pole: FloatArray) -> TwoLinks:
    """Reach from the origin to `target` (3,), the middle joint on the side of `pole` (3,).

    A target out of reach is approached as far as the links go.
    """
    wanted = float(np.linalg.norm(target))
    d = np.asarray(target, dtype=np.float64) / max(wanted, 1e-9)
    shortest = abs(length_1 - length_2) * 1.02 + 1e-6
    reach = float(np.clip(wanted, shortest, _STRETCH * (length_1 + length_2)))
    q = np.asarray(pole, dtype=np.float64) - d * float(np.dot(pole, d))
    if np.linalg.norm(q) < 1e-6:
        q = np.cross(d, [0.577, 0.577, -0.577])
    q /= np.linalg.norm(q)
    cosine_1 = (length_1**2 + reach**2 - length_2**2) / (2 * length_1 * reach)
    cosine_2 = (length_2**2 + reach**2 - length_1**2) / (2 * length_2 * reach)
    angle_1, angle_2 = np.arccos(np.clip([cosine_1, cosine_2], -1.0, 1.0))
    first = np.cos(angle_1) * d + np.sin(angle_1) * q
    second = np.cos(angle_2) * d - np.sin(angle_2) * q
    return TwoLinks(first, second, np.cross(q, d), float(angle_1 + angle_2))


def bend_rotation(a: FloatArray, b: FloatArray) -> FloatArray:
    """The rotation (3, 3) that turns unit vector `a` into unit vector `b` without twist."""
    c = float(np.dot(a, b))
    v = np.cross(a, b)
    if c < -1 + 1e-9:
        axis = np.cross(a, [0.0, 0.0, 1.0])
        axis /= np.linalg.norm(axis)
        result: FloatArray = 2 * np.outer(axis, axis) - np.eye(3)
        return result
    k = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    bent: FloatArray = np.eye(3) + k + k @ k / (1 + c)
    return bent


def _frame(link: FloatArray, hinge: FloatArray) -> FloatArray:
    return np.stack([link, hinge, np.cross(link, hinge)], axis=1)
