"""Joint angles of runs, references and landmarks: what each means, its range and its errors.

As far as nine landmarks have them, the angles are those of the International Society of
Biomechanics: Wu et al., J. Biomech. 38 (2005) 981-992, doi:10.1016/j.jbiomech.2004.05.042. Left
sides are mirrored.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray, IntArray, stretches_of
from stereotrack_core.body.skeleton import HEAD, PARTS
from stereotrack_core.recording.description import Segment
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory
from stereotrack_core.tracking.frame import Run
from stereotrack_core.tracking.stored import upright_run

NEAR_POLE = np.radians(10.0)  # an upper arm nearer to the vertical has no plane of elevation
NEARLY_STRAIGHT = np.radians(20.0)  # an elbow bent less does not show the upper arm's rotation
NEARLY_SIDEWAYS = np.radians(80.0)  # a torso or head that leans more has no turn, no tilt


_LOWEST: Mapping[str, float | None] = {
    "torso_turn": -math.pi,
    "torso_forward": -math.pi,
    "torso_sideways": None,
    "head_forward": -math.pi,
    "head_sideways": None,
    **{
        f"{side}_{name}": lowest
        for side in ("left", "right")
        for name, lowest in (
            ("shoulder_plane", math.radians(-135.0)),
            ("shoulder_elevation", None),
            ("shoulder_rotation", -math.pi),
            ("elbow_flexion", None),
        )
    },
}
"""Where the range of one turn begins, radians; None for an angle that cannot go round.

docs/angles.md says what is zero, and what is positive.
"""
NAMES: tuple[str, ...] = tuple(_LOWEST)  # all angles; every array of angles has this order
_CONTINUES = "torso_turn"  # its turns are counted on over unknown frames
_TURNS = np.array([lowest is not None for lowest in _LOWEST.values()])
_MIRROR = np.array([-1.0, 1.0, 1.0])  # at the person's plane of symmetry


def angles_of_landmarks(points: FloatArray) -> FloatArray:
    """Joint angles (..., A), radians, of landmarks (..., 9, 3), not unwrapped, or NaN."""
    at = {name: points[..., i, :] for i, name in enumerate(LANDMARKS)}
    hips = 0.5 * (at["left_hip"] + at["right_hip"])
    shoulders = 0.5 * (at["left_shoulder"] + at["right_shoulder"])
    up = unit(shoulders - hips)
    ahead = unit(np.cross(up, at["right_shoulder"] - at["left_shoulder"]))
    torso = np.stack([np.cross(ahead, up), ahead, up], axis=-1)  # world_from_torso
    turn, forward, sideways = _torso_angles(torso)
    leaning = np.abs(sideways) > NEARLY_SIDEWAYS
    head = _in_frame(torso, unit(at["head"] - shoulders))
    head_sideways = np.arctan2(head[..., 0], np.hypot(head[..., 1], head[..., 2]))
    head_leaning = np.abs(head_sideways) > NEARLY_SIDEWAYS
    found = {
        "torso_turn": np.where(leaning, np.nan, turn),
        "torso_forward": np.where(leaning, np.nan, forward),
        "torso_sideways": sideways,
        "head_forward": np.where(head_leaning, np.nan, np.arctan2(head[..., 1], head[..., 2])),
        "head_sideways": head_sideways,
    }
    for side in ("left", "right"):
        elbow = at[f"{side}_elbow"]
        upper = _in_frame(torso, unit(elbow - at[f"{side}_shoulder"]))
        fore = _in_frame(torso, unit(at[f"{side}_hand"] - elbow))
        if side == "left":
            upper, fore = upper * _MIRROR, fore * _MIRROR
        plane, elevation = _shoulder_angles(upper)
        across = np.linalg.norm(np.cross(upper, fore), axis=-1)
        flexion = np.arctan2(across, _dot(upper, fore))
        at_pole = np.sin(elevation) < np.sin(NEAR_POLE)
        straight = np.sin(flexion) < np.sin(NEARLY_STRAIGHT)
        found[f"{side}_shoulder_plane"] = np.where(at_pole, np.nan, plane)
        found[f"{side}_shoulder_elevation"] = elevation
        rotation = _axial_rotation(upper, fore)
        found[f"{side}_shoulder_rotation"] = np.where(at_pole | straight, np.nan, rotation)
        found[f"{side}_elbow_flexion"] = flexion
    return np.stack([found[name] for name in NAMES], axis=-1)


def wrapped(difference: FloatArray) -> FloatArray:
    """Differences (..., A) of angles, the short way round where an angle can go round."""
    around = np.arctan2(np.sin(difference), np.cos(difference))
    return np.where(_TURNS, around, difference)


def _torso_angles(torso: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Turn, tilt forward and tilt sideways (...) of torsos (..., 3, 3), world_from_torso.

    Y-X-Z in the recommendation's axes. The recommended Z-X-Y takes the tilt forward about an axis
    of the laboratory; here people turn freely.
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
    """Plane of elevation and elevation (...) of right upper arms (..., 3) in the torso's frame.

    The recommendation's 2.4.7, order Y-X'-Y'': with the plane gamma and beta = -elevation, the
    direction is (sin e sin gamma, -cos e, sin e cos gamma) in (X, Y, Z).
    """
    plane = np.arctan2(upper[..., 1], upper[..., 0])
    elevation = np.arctan2(np.hypot(upper[..., 0], upper[..., 1]), -upper[..., 2])
    return plane, elevation


def _axial_rotation(upper: FloatArray, fore: FloatArray) -> FloatArray:
    """Turn (...) of right upper arms about their own axis, internal positive.

    The third angle of Y-X'-Y'', second option for the humerus: Z_h is perpendicular to the plane of
    `upper` and `fore` (..., 3), unit vectors in the torso's frame, pointing to the right.
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
    return vectors / np.where(known, length, np.nan)


def _in_frame(frames: FloatArray, vectors: FloatArray) -> FloatArray:
    """Vectors (..., 3), world, in frames (..., 3, 3), world_from_frame."""
    return np.asarray(np.einsum("...ji,...j->...i", frames, vectors))


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("...i,...i->...", a, b))


@dataclass(frozen=True, eq=False)
class JointAngles:
    """Angles over frames; F frames, A angles in the order of :data:`NAMES`."""

    frame: IntArray  # (F,). Ascending.
    angle: FloatArray  # (F, A), radians. Unwrapped; NaN where not known or not defined.

    def between(self, first: int, end: int) -> JointAngles:
        """The frames of a half-open stretch."""
        inside = (self.frame >= first) & (self.frame < end)
        return JointAngles(self.frame[inside], self.angle[inside])


def angles_of_trajectory(trajectory: LandmarkTrajectory) -> JointAngles:
    """Angles of landmarks."""
    angle = unwrapped(trajectory.frame, angles_of_landmarks(trajectory.points))
    return JointAngles(trajectory.frame, angle)


def angles_of_run(run: Run) -> JointAngles:
    """Angles of a run, against the vertical of its world; the head's if it is tracked."""
    run = upright_run(run)
    found = angles_of_trajectory(run.trajectory())
    if f"{PARTS[HEAD]}_alpha" in run.state_names:
        return found
    tracked = np.array([not name.startswith("head") for name in NAMES])
    return JointAngles(found.frame, np.where(tracked, found.angle, np.nan))


def unwrapped(frame: IntArray, angle: FloatArray) -> FloatArray:
    """Take away jumps by whole turns of angles (F, A) in any range, radians.

    After unknown frames an angle begins anew in its range; turns of the torso are counted on.
    """
    result = angle.copy()
    for column, (name, lowest) in enumerate(_LOWEST.items()):
        if lowest is not None:
            begin = lowest
            for stretch in stretches_of(np.isfinite(angle[:, column]), frame):
                values = np.unwrap(angle[stretch, column])
                turns = np.floor((values[0] - begin) / (2.0 * np.pi))
                result[stretch, column] = values - 2.0 * np.pi * turns
                if name == _CONTINUES:
                    begin = result[stretch, column][-1] - np.pi
    return result


_DIGITS = 4


def frame_columns() -> tuple[str, ...]:
    """Headings: ``frame``, ``seconds``, then one for every angle."""
    return ("frame", "seconds", *(f"{name}_deg" for name in NAMES))


def frame_rows(angles: JointAngles, fps: float) -> list[list[str | float | int]]:
    """Rows under :func:`frame_columns`, seconds since frame 0; what is not known is empty."""
    rows: list[list[str | float | int]] = []
    degrees = np.degrees(angles.angle).round(_DIGITS).tolist()
    for frame, values in zip(angles.frame.tolist(), degrees, strict=True):
        cells = ["" if math.isnan(value) else value for value in values]
        rows.append([frame, round(frame / fps, 6), *cells])
    return rows


RANGES = ("minimum", "maximum", "range", "mean")  # statistics of each angle in a stretch


@dataclass(frozen=True)
class StretchRanges:
    """Ranges of the angles in one stretch of frames."""

    name: str  # the segment, or ``"all"``
    first: int
    end: int  # `first` and `end`: its frames that there are, half-open; else the segment's
    angles: dict[str, dict[str, float]]
    """Frames in which each angle is known, and those of :data:`RANGES` in degrees, else NaN."""


def angle_ranges(angles: JointAngles, segments: Sequence[Segment] = ()) -> list[StretchRanges]:
    """Ranges of the angles: over all frames first, then in every segment."""
    ends = (int(angles.frame[0]), int(angles.frame[-1]) + 1) if len(angles.frame) else (0, 0)
    found = []
    for stretch in (Segment("all", *ends), *segments):
        part = angles.between(stretch.first, stretch.end)
        first, end = stretch.first, stretch.end
        if len(part.frame):
            first, end = int(part.frame[0]), int(part.frame[-1]) + 1
        columns = [values[np.isfinite(values)] for values in np.degrees(part.angle).T]
        known: dict[str, dict[str, float]] = {}
        for name, values in zip(NAMES, columns, strict=True):
            known[name] = {"frames": len(values), **dict.fromkeys(RANGES, math.nan)}
            if len(values):
                low, high, mean = float(values.min()), float(values.max()), float(values.mean())
                known[name] |= {"minimum": low, "maximum": high, "range": high - low, "mean": mean}
        found.append(StretchRanges(stretch.name, first, end, known))
    return found


ERRORS = ("mean_error", "median", "rms", "p95")
"""Mean error with its sign; median, root mean square and 95th percentile of its size."""


def angle_errors(found: JointAngles, truth: JointAngles) -> dict[str, dict[str, float]]:
    """Errors of each angle in degrees over ``frames`` that both know; NaN without any."""
    _, own, other = np.intersect1d(found.frame, truth.frame, return_indices=True)
    errors = np.degrees(wrapped(found.angle[own] - truth.angle[other]))
    result = {}
    for name, column in zip(NAMES, errors.T, strict=True):
        known = column[np.isfinite(column)]
        told = dict.fromkeys(ERRORS, math.nan)
        if len(known):
            size = np.abs(known)
            rms = np.sqrt(np.mean(size**2))
            values = known.mean(), np.median(size), rms, np.percentile(size, 95)
            told = dict(zip(ERRORS, map(float, values), strict=True))
        result[name] = {"frames": len(known), **told}
    return result
