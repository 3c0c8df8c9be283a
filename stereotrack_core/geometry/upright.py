"""Which of a world's axes points up, and the turn to a world of the same origin in which z does."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray

_ROWS: Mapping[str, tuple[tuple[int, int, int], ...]] = MappingProxyType(
    {
        "z": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
        "y": ((1, 0, 0), (0, 0, -1), (0, 1, 0)),
        "-y": ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
        "-z": ((1, 0, 0), (0, -1, 0), (0, 0, -1)),
        "x": ((0, 1, 0), (0, 0, 1), (1, 0, 0)),
        "-x": ((0, 0, 1), (0, 1, 0), (-1, 0, 0)),
    }
)
"""Rows of upright_from_world. East, the first, is the world's x where that lies on the floor: so it
is for y up, and for cameras' own frames, whose y points down and whose z, ahead, is north."""

UP_AXES: tuple[str, ...] = tuple(_ROWS)  # names of the axes, the usual one first


@dataclass(frozen=True)
class Upright:
    """The turn of a world whose `axis` points up to one in which z does; exact."""

    axis: str = "z"

    @property
    def rotation(self) -> FloatArray:
        """upright_from_world (3, 3)."""
        return np.array(_ROWS[self.axis], dtype=np.float64)

    @property
    def up(self) -> FloatArray:
        """Unit vector (3,), world, that points up."""
        return np.asarray(self.rotation[2])

    @property
    def level(self) -> IntArray:
        """The two axes (2,) of the world that lie on the floor."""
        return np.flatnonzero(self.up == 0.0)

    def points(self, points: FloatArray) -> FloatArray:
        """Points (..., 3) of the world in the upright one; the same array where z points up."""
        return points if self.axis == UP_AXES[0] else points @ self.rotation.T


Z_UP = Upright()  # a world as it should be
