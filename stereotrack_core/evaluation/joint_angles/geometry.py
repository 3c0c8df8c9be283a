"""Joint angles of landmarks, frame by frame.

The axes of Wu et al. (2005) are X forwards, Y up and Z to the right; the torso's here are x to the
right, y forwards and z up: (X, Y, Z) = (y, z, x). The thorax is the torso: its long axis from the
middle of the hips to the middle of the shoulders takes the place of Y_t, because the model has
neither incisura jugularis, xiphoid process nor vertebrae, and the line through the shoulders, made
perpendicular to it, that of Z_t.
"""

from __future__ import annotations

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.evaluation.joint_angles.definitions import (
    ANGLES,
    NAMES,
    NEAR_POLE,
    NEARLY_SIDEWAYS,
    NEARLY_STRAIGHT,
    place_of,
)
from stereotrack_core.recording.landmarks import LANDMARKS

_TURNS = np.array([angle.lowest is not None for angle in ANGLES])
_MIRROR = np.array([-1.0, 1.0, 1.0])
"""Mirrors a vector of the torso's frame at the person's plane of symmetry."""


def angles_of_landmarks(points: FloatArray) -> FloatArray:
    """Joint angles (..., A) in radians of landmarks (..., 9, 3), world, metres.

    NaN where a landmark that the angle needs is not known, and where the angle is not defined
    (see :data:`ANGLES`); not unwrapped.
    """
    return within_limits(raw_angles(points))


def raw_angles(points: FloatArray) -> FloatArray:
    """The same without the limits near singular places, where values are wild but finite."""
    at = {name: points[..., i, :] for i, name in enumerate(LANDMARKS)}
    hips = 0.5 * (at["left_hip"] + at["right_hip"])
    shoulders = 0.5 * (at["left_shoulder"] + at["right_shoulder"])
    torso = torso_frames(hips, shoulders, at["right_shoulder"] - at["left_shoulder"])
    result: FloatArray = np.full((*points.shape[:-2], len(NAMES)), np.nan)

    def put(name: str, value: FloatArray) -> None:
        result[..., place_of(name)] = value

    for name, value in zip(("turn", "forward", "sideways"), torso_angles(torso), strict=True):
        put(f"torso_{name}", value)
    head = in_frame(torso, unit(at["head"] - shoulders))
    put("head_forward", np.arctan2(head[..., 1], head[..., 2]))
    put("head_sideways", np.arctan2(head[..., 0], np.hypot(head[..., 1], head[..., 2])))
    for side in ("left", "right"):
        elbow = at[f"{side}_elbow"]
        upper = in_frame(torso, unit(elbow - at[f"{side}_shoulder"]))
        fore = in_frame(torso, unit(at[f"{side}_hand"] - elbow))
        if side == "left":
            upper, fore = upper * _MIRROR, fore * _MIRROR
        for name, value in zip(("plane", "elevation"), shoulder_angles(upper), strict=True):
            put(f"{side}_shoulder_{name}", value)
        put(f"{side}_shoulder_rotation", axial_rotation(upper, fore))
        put(f"{side}_elbow_flexion", _between(upper, fore))
    return result


def within_limits(angles: FloatArray) -> FloatArray:
    """Angles (..., A) with NaN in place of those that the others leave undefined."""
    result = angles.copy()

    def blank(name: str, undefined: FloatArray) -> None:
        values = result[..., place_of(name)]
        result[..., place_of(name)] = np.where(undefined, np.nan, values)

    def of(name: str) -> FloatArray:
        values: FloatArray = angles[..., place_of(name)]
        return values

    leaning = np.abs(of("torso_sideways")) > NEARLY_SIDEWAYS
    blank("torso_turn", leaning)
    blank("torso_forward", leaning)
    blank("head_forward", np.abs(of("head_sideways")) > NEARLY_SIDEWAYS)
    for side in ("left", "right"):
        at_pole = np.sin(of(f"{side}_shoulder_elevation")) < np.sin(NEAR_POLE)
        straight = np.sin(of(f"{side}_elbow_flexion")) < np.sin(NEARLY_STRAIGHT)
        blank(f"{side}_shoulder_plane", at_pole)
        blank(f"{side}_shoulder_rotation", at_pole | straight)
    return result


def wrapped(difference: FloatArray) -> FloatArray:
    """Differences (..., A) of angles, the short way round where an angle can go round."""
    around = np.arctan2(np.sin(difference), np.cos(difference))
    result: FloatArray = np.where(_TURNS, around, difference)
    return result


def torso_frames(hips: FloatArray, shoulders: FloatArray, across: FloatArray) -> FloatArray:
    """world_from_torso (..., 3, 3) of the middles of hips and shoulders (..., 3), world.

    Parameters
    ----------
    hips, shoulders : (..., 3) float64, world, metres
    across : (..., 3) float64, world
        From the left to the right shoulder.
    """
    z = unit(shoulders - hips)
    y = unit(np.cross(z, across))
    return np.stack([np.cross(y, z), y, z], axis=-1)


def torso_angles(torso: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Turn, tilt forward and tilt sideways (...) of torsos (..., 3, 3), world_from_torso.

    Y-X-Z in the recommendation's axes: the turn about the vertical first, then the tilt to the
    side about the axis that points forwards, then the tilt forward about the line through the
    shoulders. The recommended Z-X-Y takes the tilt forward about an axis of the laboratory, which
    presumes that people face along its X axis; here they turn freely.
    """
    right, up = torso[..., 0], torso[..., 2]
    turn = np.arctan2(right[..., 1], right[..., 0])
    level = np.hypot(right[..., 0], right[..., 1])
    sideways = np.arctan2(-right[..., 2], level)
    zero = np.zeros_like(turn)
    ahead = np.stack([-np.sin(turn), np.cos(turn), zero], axis=-1)
    upright = np.cross(right, ahead)
    forward = np.arctan2(_dot(up, ahead), _dot(up, upright))
    return turn, forward, sideways


def shoulder_angles(upper: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Plane of elevation and elevation (...) of upper arms of the right side.

    The recommendation's 2.4.7, order Y-X'-Y'': with the plane gamma and beta = -elevation, the
    direction from shoulder to elbow is (sin e sin gamma, -cos e, sin e cos gamma) in (X, Y, Z).

    Parameters
    ----------
    upper : (..., 3) float64
        Unit vectors from shoulder to elbow in the torso's frame.
    """
    plane = np.arctan2(upper[..., 1], upper[..., 0])
    elevation = np.arctan2(np.hypot(upper[..., 0], upper[..., 1]), -upper[..., 2])
    return plane, elevation


def axial_rotation(upper: FloatArray, fore: FloatArray) -> FloatArray:
    """Turn (...) of right upper arms about their own axis, internal positive.

    The third angle of Y-X'-Y'', with the recommendation's second option for the humerus: Z_h is
    perpendicular to the plane of upper arm and forearm, pointing to the right.

    Parameters
    ----------
    upper, fore : (..., 3) float64
        Unit vectors from shoulder to elbow and from elbow to hand in the torso's frame.
    """
    plane, elevation = shoulder_angles(upper)
    zero = np.zeros_like(plane)
    # Z_h and X_h of an arm that is raised in its plane without any turn about its own axis
    across = np.stack([np.cos(plane), np.sin(plane), zero], axis=-1)
    z = np.cos(elevation)[..., None] * across + np.sin(elevation)[..., None] * [0.0, 0.0, 1.0]
    x = np.cross(-upper, z)
    own = unit(np.cross(upper, fore))
    return np.arctan2(_dot(own, x), _dot(own, z))


def unit(vectors: FloatArray) -> FloatArray:
    """Vectors (..., 3) of length one; NaN where they have no length."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    result: FloatArray = vectors / np.where(length > 0, length, np.nan)
    return result


def in_frame(frames: FloatArray, vectors: FloatArray) -> FloatArray:
    """Vectors (..., 3), world, in frames (..., 3, 3), world_from_frame."""
    result: FloatArray = np.einsum("...ji,...j->...i", frames, vectors)
    return result


def _between(a: FloatArray, b: FloatArray) -> FloatArray:
    result: FloatArray = np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), _dot(a, b))
    return result


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    result: FloatArray = np.einsum("...i,...i->...", a, b)
    return result
