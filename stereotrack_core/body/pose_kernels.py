"""Compiled loops of the kinematics: a search asks for hundreds of poses in a frame."""

from __future__ import annotations

import math
from typing import Any

import numba


@numba.njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def chain(
    turns: Any, position: Any, joints: Any, parents: Any, rotations: Any, origins: Any
) -> None:
    """Chain the transforms of S poses from the torso outwards.

    Parameters
    ----------
    turns : (S, P, 3, 3) float64
        parent_from_part, world_from_torso for the torso.
    position : (S, 3) float64, world, metres
    joints : (P, 3) float64, metres
        Joint of each part in its parent's frame.
    parents : (P,) int64
        Every parent comes before its parts.
    rotations : (S, P, 3, 3) float64
        world_from_part, filled in.
    origins : (S, P, 3) float64, world, metres
        Filled in.
    """
    for s in range(turns.shape[0]):
        rotations[s, 0] = turns[s, 0]
        origins[s, 0] = position[s]
        for part in range(1, turns.shape[1]):
            above = parents[part]
            for i in range(3):
                a, b, c = rotations[s, above, i]
                for j in range(3):
                    rotations[s, part, i, j] = (
                        a * turns[s, part, 0, j]
                        + b * turns[s, part, 1, j]
                        + c * turns[s, part, 2, j]
                    )
                origins[s, part, i] = origins[s, above, i] + (
                    a * joints[part, 0] + b * joints[part, 1] + c * joints[part, 2]
                )


@numba.njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def turn_towards(rotation: Any, direction: Any, result: Any) -> None:
    """Turn N rotations (N, 3, 3) the shortest way so that z points along directions (N, 3)."""
    turn = result[0].copy()
    for n in range(rotation.shape[0]):
        R, d = rotation[n], direction[n]
        x = R[0, 0] * d[0] + R[1, 0] * d[1] + R[2, 0] * d[2]
        y = R[0, 1] * d[0] + R[1, 1] * d[1] + R[2, 1] * d[2]
        z = R[0, 2] * d[0] + R[1, 2] * d[1] + R[2, 2] * d[2]
        length = math.sqrt(x * x + y * y + z * z)
        x, y, z = x / length, y / length, z / length
        aside = x * x + y * y
        turn[:] = 0.0
        if z < 0.0 and aside < 1e-24:
            turn[0, 0], turn[1, 1], turn[2, 2] = 1.0, -1.0, -1.0
        else:
            # 1 / (1 + z), without cancellation where z is nearly -1
            c = (1.0 - z) / aside if z < 0.0 else 1.0 / (1.0 + z)
            turn[0, 0], turn[0, 1], turn[0, 2] = 1 - c * x * x, -c * x * y, x
            turn[1, 0], turn[1, 1], turn[1, 2] = -c * x * y, 1 - c * y * y, y
            turn[2, 0], turn[2, 1], turn[2, 2] = -x, -y, z
        for i in range(3):
            for j in range(3):
                result[n, i, j] = R[i, 0] * turn[0, j] + R[i, 1] * turn[1, j] + R[i, 2] * turn[2, j]
