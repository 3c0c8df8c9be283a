"""Which landmarks are hidden behind the body, for all frames and cameras at once.

The body is a few capsules between the nine landmarks: enough to know whether a click would be a
guess. A landmark lies within the capsules that end at it; these do not hide it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray
from stereotrack_core.geometry.segments import segment_distance
from stereotrack_core.recording.landmarks import LANDMARKS

_CAPSULES: tuple[tuple[tuple[str, ...], tuple[str, ...], float], ...] = (
    (("left_hip",), ("left_shoulder",), 0.10),
    (("right_hip",), ("right_shoulder",), 0.10),
    (("left_hip", "right_hip"), ("left_shoulder", "right_shoulder"), 0.12),
    (("left_shoulder", "right_shoulder"), ("head",), 0.07),
    (("left_shoulder",), ("left_elbow",), 0.045),
    (("right_shoulder",), ("right_elbow",), 0.045),
    (("left_elbow",), ("left_hand",), 0.035),
    (("right_elbow",), ("right_hand",), 0.035),
)
"""Ends (middles of landmarks) and radius in metres."""

_AGAINST = 1.5
"""Radii before a landmark in which nothing hides it."""


def hidden_landmarks(
    nine: FloatArray, names: Sequence[str], points: FloatArray, places: FloatArray
) -> BoolArray:
    """Whether the body stands between cameras and landmarks.

    Parameters
    ----------
    nine : (F, 9, 3) float64, world, metres
        The landmarks of every reference.
    names : sequence of str
        n landmarks that are asked for.
    points : (F, n, 3) float64, world
        Where they are.
    places : (C, 3) float64, world
        Optical centres.

    Returns
    -------
    (F, C, n) bool
        False where something is not known.
    """
    sight_from = np.broadcast_to(places[None, :, None], (len(nine), len(places), len(names), 3))
    sight_to = np.broadcast_to(points[:, None], sight_from.shape)
    towards = sight_from - sight_to
    towards = towards / np.linalg.norm(towards, axis=-1, keepdims=True)
    hidden: BoolArray = np.zeros(sight_from.shape[:-1], dtype=np.bool_)
    for one, two, radius in _CAPSULES:
        ends = [
            np.mean([nine[:, LANDMARKS.index(name)] for name in end], axis=0)[:, None, None]
            for end in (one, two)
        ]
        # What lies against a capsule is not behind it.
        apart = segment_distance(sight_from, sight_to + _AGAINST * radius * towards, *ends)
        own = np.array([name in (*one, *two) for name in names])
        hidden |= (apart < radius) & ~own
    return hidden
