"""Compiled loops of the kinematics: a search asks for hundreds of poses in a frame."""

from __future__ import annotations

import math
from typing import Any

import numba
import numpy as np


@numba.njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def chain(
    turns: Any,
    position: Any,
    joints: Any,
    lengths: Any,
    parents: Any,
    carriers: Any,
    rest: Any,
    rotations: Any,
    origins: Any,
) -> None:
    """Chain the transforms of S poses from the torso outwards.

    Parameters
    ----------
    turns : (S, P, 3, 3) float64
        parent_from_part, world_from_torso for the torso.
    position : (S, 3) float64, world, metres
    joints : (P, 3) float64, metres
        Joint of each part in its parent's frame.
    lengths : (P,) float64, metres
    parents : (P,) int64
        Every parent comes before its parts.
    carriers : (P,) int64
        Part whose end carries the joint away from its place, a child of the same parent; or -1.
    rest : (P, 3, 3) float64
        Turns at which carriers leave it there.
    rotations : (S, P, 3, 3) float64
        world_from_part, filled in.
    origins : (S, P, 3) float64, world, metres
        Filled in.
    """
    for s in range(turns.shape[0]):
        rotations[s, 0] = turns[s, 0]
        origins[s, 0] = position[s]
        for part in range(1, turns.shape[1]):
            above, carrier = parents[part], carriers[part]
            x, y, z = joints[part]
            if carrier >= 0:
                x += lengths[carrier] * (turns[s, carrier, 0, 2] - rest[carrier, 0, 2])
                y += lengths[carrier] * (turns[s, carrier, 1, 2] - rest[carrier, 1, 2])
                z += lengths[carrier] * (turns[s, carrier, 2, 2] - rest[carrier, 2, 2])
            for i in range(3):
                a, b, c = rotations[s, above, i]
                for j in range(3):
                    rotations[s, part, i, j] = (
                        a * turns[s, part, 0, j]
                        + b * turns[s, part, 1, j]
                        + c * turns[s, part, 2, j]
                    )
                origins[s, part, i] = origins[s, above, i] + (a * x + b * y + c * z)


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


@numba.njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def displace(rotations: Any, joints: Any, delta: Any, result: Any) -> None:
    """Turn the parts of one pose by S error states.

    Parameters
    ----------
    rotations : (P, 3, 3) float64
        Of the pose.
    joints : (J,) int64
        Parts whose joints are in the state.
    delta : (S, 6 + 2 J) float64
    result : (S, P, 3, 3) float64
        Filled in.
    """
    turn = np.empty((3, 3))
    for s in range(delta.shape[0]):
        result[s] = rotations
        _turn(delta[s, 3], delta[s, 4], delta[s, 5], turn)
        _multiplied(turn, rotations[0], result[s, 0])
        for k in range(joints.shape[0]):
            _turn(delta[s, 6 + 2 * k], delta[s, 7 + 2 * k], 0.0, turn)
            _multiplied(rotations[joints[k]], turn, result[s, joints[k]])


@numba.njit(cache=True, nogil=True, inline="always")  # type: ignore[untyped-decorator]
def _turn(x: float, y: float, z: float, turn: Any) -> None:
    """Fill the rotation matrix of a rotation vector (Rodrigues)."""
    squared = x * x + y * y + z * z
    if squared < 1e-8:
        a, b = 1.0 - squared / 6.0, 0.5 - squared / 24.0
    else:
        angle = math.sqrt(squared)
        a, b = math.sin(angle) / angle, (1.0 - math.cos(angle)) / squared
    xx, yy, zz, xy, xz, yz = b * x * x, b * y * y, b * z * z, b * x * y, b * x * z, b * y * z
    turn[0, 0], turn[0, 1], turn[0, 2] = 1.0 - yy - zz, xy - a * z, xz + a * y
    turn[1, 0], turn[1, 1], turn[1, 2] = xy + a * z, 1.0 - xx - zz, yz - a * x
    turn[2, 0], turn[2, 1], turn[2, 2] = xz - a * y, yz + a * x, 1.0 - xx - yy


@numba.njit(cache=True, nogil=True, inline="always")  # type: ignore[untyped-decorator]
def _multiplied(A: Any, B: Any, result: Any) -> None:
    for i in range(3):
        for j in range(3):
            result[i, j] = A[i, 0] * B[0, j] + A[i, 1] * B[1, j] + A[i, 2] * B[2, j]


@numba.njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def localise(points: Any, part: Any, rotations: Any, origins: Any, local: Any) -> None:
    """Fill places (N, 3) in the frames of their parts of points (N, 3), world."""
    for n in range(points.shape[0]):
        p = part[n]
        x, y = points[n, 0] - origins[p, 0], points[n, 1] - origins[p, 1]
        z = points[n, 2] - origins[p, 2]
        for j in range(3):
            local[n, j] = x * rotations[p, 0, j] + y * rotations[p, 1, j] + z * rotations[p, 2, j]
