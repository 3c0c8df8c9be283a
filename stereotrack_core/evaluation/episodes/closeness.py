"""How near arms come to each other and to the torso, and how fast limbs turn, by landmarks."""

from __future__ import annotations

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.geometry.rotation import angle_between
from stereotrack_core.geometry.segments import segment_distance
from stereotrack_core.recording.landmarks import LANDMARKS

_SIDES = ("left", "right")
_BESIDE = 0.35
"""Share of an upper arm, from the shoulder, that is always near the torso."""


def limb_axes(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Starts and ends (F, 6, 3) of the limbs' axes by landmarks (F, 9, 3); NaN stays."""
    at = {name: points[:, i] for i, name in enumerate(LANDMARKS)}
    hips = 0.5 * (at["left_hip"] + at["right_hip"])
    neck = 0.5 * (at["left_shoulder"] + at["right_shoulder"])
    ends = {"torso": (hips, neck), "head": (neck, at["head"])}
    for side in _SIDES:
        ends[f"{side}_upper_arm"] = at[f"{side}_shoulder"], at[f"{side}_elbow"]
        ends[f"{side}_forearm"] = at[f"{side}_elbow"], at[f"{side}_hand"]
    starts = np.stack([ends[limb][0] for limb in LIMBS], axis=1)
    return starts, np.stack([ends[limb][1] for limb in LIMBS], axis=1)


def to_other_arm(points: FloatArray) -> FloatArray:
    """Least distance (F, 6) of each arm's limb to the other arm's forearm, metres.

    Forearms are measured to the whole other arm. NaN for torso and head.
    """
    start, end = limb_axes(points)
    result: FloatArray = np.full(start.shape[:2], np.nan)
    for side, other in (_SIDES, _SIDES[::-1]):
        upper, fore = LIMBS.index(f"{side}_upper_arm"), LIMBS.index(f"{side}_forearm")
        theirs = LIMBS.index(f"{other}_upper_arm"), LIMBS.index(f"{other}_forearm")

        def away(mine: int, its: int) -> FloatArray:
            return segment_distance(start[:, mine], end[:, mine], start[:, its], end[:, its])

        result[:, upper] = away(upper, theirs[1])
        result[:, fore] = np.minimum(away(fore, theirs[0]), away(fore, theirs[1]))
    return result


def to_torso(points: FloatArray) -> FloatArray:
    """Least distance (F, 6) of each arm's limb to the middle of the torso, metres.

    The torso is the line from the middle of the hips to that of the shoulders; of an upper arm
    the part near the shoulder is left out. NaN for torso and head.
    """
    start, end = limb_axes(points)
    torso = LIMBS.index("torso")
    result: FloatArray = np.full(start.shape[:2], np.nan)
    for limb, name in enumerate(LIMBS):
        if name in {"torso", "head"}:
            continue
        from_here = start[:, limb]
        if name.endswith("upper_arm"):
            from_here = from_here + _BESIDE * (end[:, limb] - from_here)
        result[:, limb] = segment_distance(from_here, end[:, limb], start[:, torso], end[:, torso])
    return result


def turns(frame: FloatArray, points: FloatArray) -> FloatArray:
    """Angle (F, 6) in degrees by which each limb has turned since the frame before.

    0 in the first frame and after a gap; NaN where a limb is not known.

    Parameters
    ----------
    frame : (F,)
        Frame numbers.
    points : (F, 9, 3) float64
    """
    start, end = limb_axes(points)
    axis = end - start
    result: FloatArray = np.zeros(axis.shape[:2])
    if len(axis) > 1:
        turned = np.degrees(angle_between(axis[1:], axis[:-1]))
        result[1:] = np.where((np.diff(frame) == 1)[:, None], turned, 0.0)
    return result
