"""Clicks and frames that somebody should look at again, and by how many degrees that may help.

A click that is a gross mistake with the probability p gives nothing to the fit, which leaves it out
in proportion: to click right there would gain p times what a new click gains. As far as the fit has
believed it, with 1 - p, it has pulled the limb, by at most the angle of its residual.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.annotation.click import Click, ClickKey
from stereotrack_core.annotation.fit.results import MISTAKEN, TrajectoryFit
from stereotrack_core.annotation.landmark_set import LandmarkSet
from stereotrack_core.annotation.swaps import Swap, find_swaps
from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.rotation import angle_between
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory

HIGH_RESIDUAL = 4.0
"""Usual sigmas from which a residual is worth a look."""

_LIMB_LENGTH = 0.3
"""Metres; what a place that is off does to a direction."""

_DIRECTIONS: dict[str, tuple[str, str]] = {
    "left_upper_arm": ("left_shoulder", "left_elbow"),
    "right_upper_arm": ("right_shoulder", "right_elbow"),
    "left_forearm": ("left_elbow", "left_hand"),
    "right_forearm": ("right_elbow", "right_hand"),
}


@dataclass(frozen=True)
class Doubt:
    """Something about a click that is there.

    Attributes
    ----------
    mistake : float
        Probability that it is a gross mistake.
    angle_deg : float
        What its residual would do to a limb, degrees.
    words : str
    """

    mistake: float
    angle_deg: float
    words: str


def doubts_of(
    fit: TrajectoryFit, cameras: Mapping[str, Camera], sigma: float
) -> dict[ClickKey, Doubt]:
    """Clicks that are probably mistakes, or lie far from the fit."""
    rows = {int(frame): row for row, frame in enumerate(fit.frame)}
    found = {}
    for key, residual in fit.residual_px.items():
        mistake = float(fit.mistake.get(key, 0.0))
        length = float(np.linalg.norm(residual))
        camera = cameras.get(key.camera)
        if camera is None or not (mistake > MISTAKEN or length > HIGH_RESIDUAL * sigma):
            continue
        if key.frame not in rows or key.landmark not in fit.names:
            continue
        point = fit.landmarks[rows[key.frame], fit.names.index(key.landmark)]
        angle = _angle_deg(camera, point, length)
        what = "probable outlier" if mistake > MISTAKEN else "far from the fit"
        found[key] = Doubt(mistake, angle, f"{what}, {length:.0f} px")
    return found


def swaps_of(
    clicks: Iterable[Click],
    cameras: Mapping[str, Camera],
    landmark_set: LandmarkSet,
    frames: Iterable[int],
    sigma: float,
) -> dict[ClickKey, Doubt]:
    """Clicks of left and right that seem mixed up in some of the frames."""
    chosen = set(frames)
    there = [click for click in clicks if click.frame in chosen]
    found = {}
    for swap in find_swaps(there, cameras, landmark_set.pairs(), sigma=sigma):
        for camera in swap.cameras:
            for name in (swap.first, swap.second):
                found[ClickKey(swap.frame, camera, name)] = Doubt(1.0, 0.0, _words(swap))
    return found


def disagreement_deg(
    fit: TrajectoryFit, run: LandmarkTrajectory, limbs: Sequence[str] = tuple(_DIRECTIONS)
) -> FloatArray:
    """Angles (F, 6) in degrees between a tracker's arms and the fit's; NaN where not known."""
    result: FloatArray = np.full((len(fit.frame), len(LIMBS)), np.nan)
    _, ours, theirs = np.intersect1d(fit.frame, run.frame, return_indices=True)
    for limb in limbs:
        if limb in _DIRECTIONS:
            start, end = (LANDMARKS.index(name) for name in _DIRECTIONS[limb])
            own = fit.nine[ours, end] - fit.nine[ours, start]
            other = run.points[theirs, end] - run.points[theirs, start]
            result[ours, LIMBS.index(limb)] = np.degrees(angle_between(own, other))
    return result


def _angle_deg(camera: Camera, point: FloatArray, pixels: float) -> float:
    """Angle by which a limb turns whose end is moved by so many pixels in an image."""
    depth = float(np.linalg.norm(point - camera.position_world))
    focal = float(0.5 * (camera.matrix[0, 0] + camera.matrix[1, 1]))
    angle = np.degrees(np.arctan2(pixels * depth / focal, _LIMB_LENGTH))
    return float(np.nan_to_num(angle))


def _words(swap: Swap) -> str:
    names = f"{swap.first} and {swap.second}".replace("_", " ")
    return f"{names} seem to be swapped" + ("" if swap.certain else " here or in the other views")
