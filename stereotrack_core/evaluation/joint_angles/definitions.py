"""Which joint angles there are, and exactly what each means.

As far as nine landmarks have them, the angles are those that the International Society of
Biomechanics recommends: Wu et al., J. Biomech. 38 (2005) 981-992,
doi:10.1016/j.jbiomech.2004.05.042. Left sides are mirrored at the person's plane of symmetry, so
that the same movement of either arm has the same numbers.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.recording.landmarks import LANDMARKS

Side: TypeAlias = Literal["", "left", "right"]

NEAR_POLE = np.radians(10.0)
"""An upper arm that hangs down or points up more nearly than this has no plane of elevation."""

NEARLY_STRAIGHT = np.radians(20.0)
"""An elbow that is bent less does not show how the upper arm is turned about its own axis."""

NEARLY_SIDEWAYS = np.radians(80.0)
"""A torso or head that leans more to a side has neither a turn nor a tilt forward."""


@dataclass(frozen=True)
class AngleDefinition:
    """One angle."""

    name: str
    """Key, for example ``"left_shoulder_elevation"``."""
    label: str
    """For people, without the side."""
    joint: str
    """``torso``, ``head``, ``shoulder`` or ``elbow``."""
    side: Side
    limb: str
    """Limb whose colour it has."""
    meaning: str
    """What is zero, and what is positive."""
    lowest: float | None = None
    """Where the range of one turn begins, radians; None for an angle that cannot go round."""
    continues: bool = False
    """Whether turns are counted on over frames in which the angle is not known."""

    @property
    def words(self) -> str:
        """The label with the side."""
        return f"{self.side} {self.label}".strip()


def _arm(side: Literal["left", "right"]) -> tuple[AngleDefinition, ...]:
    return (
        AngleDefinition(
            f"{side}_shoulder_plane", "shoulder plane of elevation", "shoulder", side,
            f"{side}_upper_arm",
            "0 when the upper arm is raised sideways (abduction), 90 forwards (flexion), negative "
            "backwards; undefined within 10 deg of hanging down or pointing up",
            lowest=float(np.radians(-135.0)),
        ),
        AngleDefinition(
            f"{side}_shoulder_elevation", "shoulder elevation", "shoulder", side,
            f"{side}_upper_arm",
            "0 when the upper arm hangs along the torso, 90 at a right angle, 180 pointing up",
        ),
        AngleDefinition(
            f"{side}_shoulder_rotation", "shoulder axial rotation", "shoulder", side,
            f"{side}_upper_arm",
            "rotation of the upper arm about its own axis, measured by the forearm: internal "
            "positive, external negative; undefined when the elbow is bent less than 20 deg or "
            "the plane of elevation is undefined",
            lowest=-float(np.pi),
        ),
        AngleDefinition(
            f"{side}_elbow_flexion", "elbow flexion", "elbow", side, f"{side}_forearm",
            "0 when the arm is straight, positive when bent",
        ),
    )  # fmt: skip


ANGLES: tuple[AngleDefinition, ...] = (
    AngleDefinition(
        "torso_turn", "torso rotation", "torso", "", "torso",
        "0 facing north (the world's y axis), positive to the person's left; full turns are "
        "accumulated; undefined when the torso leans more than 80 deg to a side",
        lowest=-float(np.pi), continues=True,
    ),
    AngleDefinition(
        "torso_forward", "torso forward tilt", "torso", "", "torso",
        "0 upright, positive when bent forwards, negative backwards; undefined when the torso "
        "leans more than 80 deg to a side",
        lowest=-float(np.pi),
    ),
    AngleDefinition(
        "torso_sideways", "torso lateral tilt", "torso", "", "torso",
        "0 when the shoulders are level, positive when the person's right shoulder is lower",
    ),
    AngleDefinition(
        "head_forward", "head forward tilt", "head", "", "head",
        "relative to the torso: 0 when the head landmark is straight above the shoulders, "
        "positive forwards",
        lowest=-float(np.pi),
    ),
    AngleDefinition(
        "head_sideways", "head lateral tilt", "head", "", "head",
        "relative to the torso: positive towards the person's right shoulder",
    ),
    *_arm("left"),
    *_arm("right"),
)  # fmt: skip
"""All angles; every array of angles has this order."""

NAMES: tuple[str, ...] = tuple(angle.name for angle in ANGLES)


def place_of(name: str) -> int:
    """Place of an angle in arrays. Raises ValueError for a name that no angle has."""
    return NAMES.index(name)


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
    torso = _torso_frames(hips, shoulders, at["right_shoulder"] - at["left_shoulder"])
    result: FloatArray = np.full((*points.shape[:-2], len(NAMES)), np.nan)

    def put(name: str, value: FloatArray) -> None:
        result[..., place_of(name)] = value

    for name, value in zip(("turn", "forward", "sideways"), _torso_angles(torso), strict=True):
        put(f"torso_{name}", value)
    head = _in_frame(torso, unit(at["head"] - shoulders))
    put("head_forward", np.arctan2(head[..., 1], head[..., 2]))
    put("head_sideways", np.arctan2(head[..., 0], np.hypot(head[..., 1], head[..., 2])))
    for side in ("left", "right"):
        elbow = at[f"{side}_elbow"]
        upper = _in_frame(torso, unit(elbow - at[f"{side}_shoulder"]))
        fore = _in_frame(torso, unit(at[f"{side}_hand"] - elbow))
        if side == "left":
            upper, fore = upper * _MIRROR, fore * _MIRROR
        for name, value in zip(("plane", "elevation"), _shoulder_angles(upper), strict=True):
            put(f"{side}_shoulder_{name}", value)
        put(f"{side}_shoulder_rotation", _axial_rotation(upper, fore))
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


def _torso_frames(hips: FloatArray, shoulders: FloatArray, across: FloatArray) -> FloatArray:
    """world_from_torso (..., 3, 3) of middles of hips and shoulders, and left to right shoulder."""
    z = unit(shoulders - hips)
    y = unit(np.cross(z, across))
    return np.stack([np.cross(y, z), y, z], axis=-1)


def _torso_angles(torso: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
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


def _shoulder_angles(upper: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Plane of elevation and elevation (...) of upper arms of the right side.

    The recommendation's 2.4.7, order Y-X'-Y'': with the plane gamma and beta = -elevation, the
    direction from shoulder to elbow is (sin e sin gamma, -cos e, sin e cos gamma) in (X, Y, Z).
    `upper` (..., 3) are unit vectors from shoulder to elbow in the torso's frame.
    """
    plane = np.arctan2(upper[..., 1], upper[..., 0])
    elevation = np.arctan2(np.hypot(upper[..., 0], upper[..., 1]), -upper[..., 2])
    return plane, elevation


def _axial_rotation(upper: FloatArray, fore: FloatArray) -> FloatArray:
    """Turn (...) of right upper arms about their own axis, internal positive.

    The third angle of Y-X'-Y'', with the recommendation's second option for the humerus: Z_h is
    perpendicular to the plane of upper arm and forearm, pointing to the right.
    `upper` and `fore` (..., 3) are unit vectors along both halves of the arm in the torso's frame.
    """
    plane, elevation = _shoulder_angles(upper)
    zero = np.zeros_like(plane)
    # Z_h and X_h of an arm that is raised in its plane without any turn about its own axis
    across = np.stack([np.cos(plane), np.sin(plane), zero], axis=-1)
    z = np.cos(elevation)[..., None] * across + np.sin(elevation)[..., None] * [0.0, 0.0, 1.0]
    x = np.cross(-upper, z)
    own = unit(np.cross(upper, fore))
    return np.arctan2(_dot(own, x), _dot(own, z))


def unit(vectors: FloatArray) -> FloatArray:
    """Vectors (..., 3) of length one; NaN where they have none, or it is infinite."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    known = (length > 0) & np.isfinite(length)
    result: FloatArray = vectors / np.where(known, length, np.nan)
    return result


def _in_frame(frames: FloatArray, vectors: FloatArray) -> FloatArray:
    """Vectors (..., 3), world, in frames (..., 3, 3), world_from_frame."""
    result: FloatArray = np.einsum("...ji,...j->...i", frames, vectors)
    return result


def _between(a: FloatArray, b: FloatArray) -> FloatArray:
    result: FloatArray = np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), _dot(a, b))
    return result


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    result: FloatArray = np.einsum("...i,...i->...", a, b)
    return result
