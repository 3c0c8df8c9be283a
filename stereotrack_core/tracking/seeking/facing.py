"""Which way somebody faces: bodies look much the same from behind, but do not bend that way."""

from __future__ import annotations

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.body.skeleton import (
    CLAVICLES,
    LEFT_FOREARM,
    LEFT_SHANK,
    LEFT_THIGH,
    LEFT_UPPER_ARM,
    RIGHT_FOREARM,
    RIGHT_SHANK,
    RIGHT_THIGH,
    RIGHT_UPPER_ARM,
    TORSO,
)

_HALF_TURN = np.diag([-1.0, -1.0, 1.0])

_PAIRS = (
    (LEFT_UPPER_ARM, RIGHT_UPPER_ARM),
    (LEFT_FOREARM, RIGHT_FOREARM),
    (LEFT_THIGH, RIGHT_THIGH),
    (LEFT_SHANK, RIGHT_SHANK),
    CLAVICLES,
)

_LEGS = ((LEFT_THIGH, LEFT_SHANK), (RIGHT_THIGH, RIGHT_SHANK))

_KNEE, _THIGH, _LEAN, _FEET = 10.0, 5.0, 8.0, 8.0
"""Costs of one knee bent forward, one thigh far behind, a trunk bent backward, two feet turned
backward; in data explained, as those of the search for arms."""

_STRAIGHT = 0.2
"""Radians up to which a knee that is bent forward may be a straight one of another shape."""

_TURNED_AWAY = 20.0
"""Cost of turning one's back on the only camera: people are filmed where one sees what they do."""

_HEADLONG = 20.0
"""Cost of a trunk whose head hangs under its hips."""

_ANKLE, _ROUND_ANKLE = 0.06, 0.22
"""Metres over the ankle, and around it, in which data are a foot's."""

_LEAST_ON_FOOT = 8


def turned_round(pose: Pose) -> Pose:
    """The pose that looks most alike from the other side: half a turn, left and right exchanged."""
    rotations = pose.rotations.copy()
    for left, right in _PAIRS:
        rotations[left], rotations[right] = pose.rotations[right], pose.rotations[left]
    rotations[1:] = _HALF_TURN @ rotations[1:] @ _HALF_TURN
    rotations[TORSO] = pose.torso @ _HALF_TURN
    return Pose(pose.position, rotations)


def facing_cost(body: BodyModel, pose: Pose, points: FloatArray, cameras: FloatArray) -> float:
    """What speaks against the direction that a pose faces, apart from its arms.

    Parameters
    ----------
    body : BodyModel
    pose : Pose
    points : (N, 3) float64, world
        The body's data.
    cameras : (V, 3) float64, world
        Optical centres. Where they stand all around they say nothing.
    """
    frames = body.frames(pose)
    legs = _legs_cost(frames) + _feet_cost(body, frames, points)
    return legs + _lean_cost(frames) + _away_cost(frames, cameras)


def _legs_cost(frames: PartFrames) -> float:
    """Knees bend backward, and thighs rise to the front."""
    total, torso = 0.0, frames.rotations[TORSO]
    for thigh, shank in _LEGS:
        along = torso.T @ frames.rotations[[thigh, shank], :, 2].T
        swing = np.arctan2(along[1], -along[2])
        bend = float((swing[0] - swing[1] + np.pi) % (2.0 * np.pi) - np.pi)
        total += _KNEE * float(np.clip((-bend - _STRAIGHT) / 0.25, 0.0, 2.0))
        total += _THIGH * float(np.clip((-swing[0] - 0.5) / 0.3, 0.0, 2.0))
    return total


def _lean_cost(frames: PartFrames) -> float:
    """Trunks bend to the front."""
    forward = _on_floor(frames)
    up = frames.rotations[TORSO, :, 2]
    lean = float(np.degrees(np.arctan2(up @ forward, max(up[2], 1e-3))))
    headlong = _HEADLONG * float(np.clip((-0.15 - up[2]) / 0.3, 0.0, 2.0))
    return headlong + _LEAN * float(np.clip((-lean - 12.0) / 12.0, 0.0, 3.0))


def _feet_cost(body: BodyModel, frames: PartFrames, points: FloatArray) -> float:
    """Toes lie in front of the ankles; nothing is said where no foot is seen."""
    forward, total = _on_floor(frames), 0.0
    for _, shank in _LEGS:
        along = frames.rotations[shank, :, 2]
        ankle = frames.origins[shank] + body.skeleton.lengths[shank] * along
        off = points[points[:, 2] < ankle[2] + _ANKLE] - ankle
        near = np.hypot(off[:, 0], off[:, 1]) < _ROUND_ANKLE
        if np.count_nonzero(near) >= _LEAST_ON_FOOT:
            ahead = float(np.median(off[near] @ forward))
            total += 0.25 * _FEET * (1.0 - float(np.clip(ahead / 0.04, -1.0, 1.0)))
    return total


def _away_cost(frames: PartFrames, cameras: FloatArray) -> float:
    """Cost of facing away from where the cameras stand together."""
    to_cameras = (cameras - frames.origins[TORSO])[:, :2]
    distance = np.maximum(np.linalg.norm(to_cameras, axis=1, keepdims=True), 1e-6)
    towards = (to_cameras / distance).mean(axis=0)
    together = float(np.linalg.norm(towards))
    cosine = float(_on_floor(frames)[:2] @ towards) / max(together, 1e-6)
    return _TURNED_AWAY * together**2 * 0.5 * (1.0 - cosine)


def _on_floor(frames: PartFrames) -> FloatArray:
    """Horizontal unit vector (3,) along which the torso faces; 0 where it faces up or down."""
    ahead = frames.rotations[TORSO, :, 1] * np.array([1.0, 1.0, 0.0])
    result: FloatArray = ahead / max(float(np.linalg.norm(ahead)), 1e-6)
    return result
