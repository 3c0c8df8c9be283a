"""Collision avoidance as the thesis does it: a jump after the last iteration (3.2.4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import PartFrames, Pose, rotation_towards
from stereotrack_core.body.skeleton import FOREARMS, TORSO, UPPER_ARMS


@dataclass(frozen=True)
class Clearance:
    """Least distances and angles that a pose must keep."""

    distance: float
    """Metres. Of elbow and hand from the torso's elliptic cross-section, measured radially."""
    elbow_angle: float
    """Radians. Between upper arm and forearm."""


def collisions_avoided(body: BodyModel, pose: Pose, clearance: Clearance) -> Pose:
    """Move elbows and hands off the torso and unfold arms that are folded too far.

    The shoulder is corrected first; then the elbow, so that the hand comes as near as possible
    to where it was before anything was changed, or to where the torso lets it be.
    """
    for upper, fore in zip(UPPER_ARMS, FOREARMS, strict=True):
        pose = _arm_corrected(body, pose, upper, fore, clearance)
    return pose


def _arm_corrected(
    body: BodyModel, pose: Pose, upper: int, fore: int, clearance: Clearance
) -> Pose:
    frames = body.frames(pose)
    elbow = _in_torso(frames, frames.origins[fore])
    hand = _in_torso(frames, _hand(body, frames, fore))
    free_elbow = pushed_out(body, elbow, clearance.distance)
    free_hand = pushed_out(body, hand, clearance.distance)
    if free_elbow is not elbow:
        pose = _aimed(pose, upper, free_elbow - body.skeleton.joints[upper])
    if free_elbow is not elbow or free_hand is not hand:
        frames = body.frames(pose)
        target = frames.rotations[TORSO] @ free_hand + frames.origins[TORSO]
        local = frames.rotations[upper].T @ (target - frames.origins[fore])
        pose = _aimed(pose, fore, local)
    return _unfolded(pose, fore, clearance.elbow_angle)


def _in_torso(frames: PartFrames, point: FloatArray) -> FloatArray:
    result: FloatArray = frames.rotations[TORSO].T @ (point - frames.origins[TORSO])
    return result


def _hand(body: BodyModel, frames: PartFrames, fore: int) -> FloatArray:
    length = body.skeleton.lengths[fore]
    result: FloatArray = frames.origins[fore] + length * frames.rotations[fore, :, 2]
    return result


def pushed_out(body: BodyModel, point: FloatArray, distance: float) -> FloatArray:
    """Move a point (3,), torso frame, radially to the least distance; the same array if it has."""
    if not 0.0 <= point[2] <= body.skeleton.proportions.torso_length:
        return point
    cones = body.cones
    height = point[2] - cones.origins[0, 2]
    axis = cones.origins[0] + height * cones.rotations[0, :, 2]
    radius = cones.r1[0] + (cones.r2[0] - cones.r1[0]) * height / cones.height[0]
    across = point[:2] - axis[:2]
    length = float(np.linalg.norm(across))
    outward = across / length if length > 1e-9 else np.array([0.0, 1.0])
    on_ellipse = radius / np.hypot(outward[0], outward[1] / cones.flatness[0])
    if length - on_ellipse >= distance:
        return point
    return np.append(axis[:2] + outward * (on_ellipse + distance), point[2])


def _aimed(pose: Pose, part: int, direction: FloatArray) -> Pose:
    length = float(np.linalg.norm(direction))
    if length < 1e-9:
        return pose
    rotations = pose.rotations.copy()
    rotations[part] = rotation_towards(rotations[part], direction / length)
    return Pose(pose.position, rotations)


def _unfolded(pose: Pose, fore: int, least: float) -> Pose:
    """Open the elbow to the least angle in the plane in which it is bent."""
    along = pose.rotations[fore, :, 2]
    largest_bend = np.pi - least
    bend = np.arccos(np.clip(along[2], -1.0, 1.0))
    if bend <= largest_bend:
        return pose
    across = along[:2] / max(float(np.linalg.norm(along[:2])), 1e-9)
    if not across.any():
        across = np.array([0.0, 1.0])
    return _aimed(pose, fore, np.append(np.sin(largest_bend) * across, np.cos(largest_bend)))
