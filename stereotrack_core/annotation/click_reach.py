"""How far a click tells about the frames around it.

Limbs move smoothly, so a click also makes the frames around it surer: by a share that falls from
one to nothing at the landmark's next click, or `reach` frames away where there is none so near.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stereotrack_core.arrays import BoolArray, FloatArray, IntArray
from stereotrack_core.geometry.segments import segment_distance
from stereotrack_core.recording.landmarks import LANDMARKS

REACH = 6
"""Frames. On recordings of fast arm movements at 10 frames per second, suggestions ranked with 3, 6
or 12 frames gave about the same errors, and without this a fifth to a third larger ones."""


UNTIL_FIT = 15
"""Frames around a new click that count as surer until the next fit, so that the next suggestions go
elsewhere; fewer led to clicks too close to each other."""


def distances(clicked: BoolArray, reach: int) -> tuple[IntArray, IntArray]:
    """Frames to the click before and the click after, at most `reach`.

    Parameters
    ----------
    clicked : (F, n) bool
        Whether a landmark has a click at a frame.
    reach : int

    Returns
    -------
    before, after : (F, n) int64
        0 at frames with a click.
    """
    frames = np.arange(len(clicked))[:, None]
    far = len(clicked) + reach
    last = np.maximum.accumulate(np.where(clicked, frames, -far), axis=0)
    following = np.where(clicked, frames, 2 * far)[::-1]
    following = np.minimum.accumulate(following, axis=0)[::-1]
    return np.minimum(frames - last, reach), np.minimum(following - frames, reach)


def over_frames(gain: FloatArray, clicked: BoolArray, reach: int) -> FloatArray:
    """Gains (F, C, n) summed up over the frames that a click at each place tells about.

    Parameters
    ----------
    gain : (F, C, n) float64
        What a click would gain at its own frame.
    clicked : (F, n) bool
    reach : int

    Returns
    -------
    (F, C, n) float64
        Degrees times frames.
    """
    before, after = distances(clicked, reach)
    total = gain.copy()
    for away in range(1, min(reach, len(gain))):
        earlier = np.clip(1.0 - away / np.maximum(before, 1), 0.0, 1.0)[:, None]
        later = np.clip(1.0 - away / np.maximum(after, 1), 0.0, 1.0)[:, None]
        total[away:] += earlier[away:] * gain[:-away]
        total[:-away] += later[:-away] * gain[away:]
    return total


def shares_around(row: int, clicked: BoolArray, reach: int) -> tuple[IntArray, FloatArray]:
    """Rows that profit from a click at one row, itself among them, and by which share.

    Parameters
    ----------
    row : int
    clicked : (F,) bool
        Of the landmark; what it says of `row` does not count.
    reach : int
    """
    others = np.flatnonzero(clicked)
    before, after = others[others < row], others[others > row]
    low = max(int(before[-1]) if len(before) else -1, row - reach)
    high = min(int(after[0]) if len(after) else len(clicked), row + reach)
    low_side = row - reach if not len(before) else low
    high_side = row + reach if not len(after) else high
    rows = np.arange(low + 1, high)
    share = np.where(
        rows < row,
        (rows - low_side) / max(row - low_side, 1),
        (high_side - rows) / max(high_side - row, 1),
    )
    return rows, share


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
