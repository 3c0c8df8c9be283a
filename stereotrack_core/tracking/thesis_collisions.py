"""Collision avoidance as the thesis does it: a jump after the last iteration (3.2.4)."""

from dataclasses import dataclass

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import Pose, rotation_towards
from stereotrack_core.body.skeleton import FOREARMS, TORSO, UPPER_ARMS


@dataclass(frozen=True)
class ArmCollision:
    """How far one arm did not keep the least distances and angles; 0 where it did."""

    elbow_missing: float
    hand_missing: float  # both in metres, to the least distance from the torso
    bend_missing: float  # radians by which the elbow was folded too far


@dataclass(frozen=True, eq=False)
class Jump:
    """What collision avoidance has found and done."""

    before: Pose
    after: Pose
    arms: tuple[ArmCollision, ArmCollision]  # left and right
    least_distance: float  # metres


def collisions_avoided(
    body: BodyModel, pose: Pose, least_distance: float, least_elbow_angle: float
) -> Jump:
    """Move elbows and hands off the torso and unfold arms that are folded too far.

    They keep `least_distance`, metres, measured radially from the torso's elliptic cross-section,
    and the least elbow angle, radians. The shoulder is corrected first; then the elbow, so that the
    hand comes as near as possible to where it was or the torso lets it be.
    """
    limits = least_distance, np.pi - least_elbow_angle
    halfway, left = _arm_corrected(body, pose, UPPER_ARMS[0], FOREARMS[0], *limits)
    after, right = _arm_corrected(body, halfway, UPPER_ARMS[1], FOREARMS[1], *limits)
    return Jump(pose, after, (left, right), least_distance)


def _arm_corrected(
    body: BodyModel, pose: Pose, upper: int, fore: int, least: float, largest_bend: float
) -> tuple[Pose, ArmCollision]:
    frames, bend = body.frames(pose), _bend(pose, fore)
    torso, origin = frames.rotations[TORSO], frames.origins[TORSO]
    hand = frames.origins[fore] + body.skeleton.lengths[fore] * frames.rotations[fore, :, 2]
    elbow, hand = (torso.T @ (place - origin) for place in (frames.origins[fore], hand))
    free_elbow, free_hand = (_pushed_out(body, place, least) for place in (elbow, hand))
    if free_elbow is not elbow:
        pose = _aimed(pose, upper, free_elbow - body.skeleton.joints[upper])
    if free_elbow is not elbow or free_hand is not hand:
        frames = body.frames(pose)
        target = frames.rotations[TORSO] @ free_hand + frames.origins[TORSO]
        local = frames.rotations[upper].T @ (target - frames.origins[fore])
        pose = _aimed(pose, fore, local)
    collision = ArmCollision(
        elbow_missing=float(np.linalg.norm(free_elbow - elbow)),
        hand_missing=float(np.linalg.norm(free_hand - hand)),
        bend_missing=max(0.0, bend - largest_bend),
    )
    return _unfolded(pose, fore, largest_bend), collision


def _bend(pose: Pose, fore: int) -> float:
    return float(np.arccos(np.clip(pose.rotations[fore, 2, 2], -1.0, 1.0)))


def _pushed_out(body: BodyModel, point: FloatArray, distance: float) -> FloatArray:
    """Move a point (3,), torso frame, radially to the least distance; the same array if it has."""
    if not 0.0 <= point[2] <= body.skeleton.proportions.torso_length:
        return point
    cones = body.cones
    height = point[2] - cones["origin"][0, 2]
    axis = cones["origin"][0] + height * cones["rotation"][0, :, 2]
    radius = cones["r1"][0] + (cones["r2"][0] - cones["r1"][0]) * height / cones["height"][0]
    across = point[:2] - axis[:2]
    length = float(np.linalg.norm(across))
    outward = across / length if length > 1e-9 else np.array([0.0, 1.0])
    on_ellipse = radius / np.hypot(outward[0], outward[1] / cones["flatness"][0])
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


def _unfolded(pose: Pose, fore: int, largest_bend: float) -> Pose:
    """Open the elbow as far as it must be, in the plane in which it is bent."""
    if _bend(pose, fore) <= largest_bend:
        return pose
    across = pose.rotations[fore, :2, 2]
    across = across / max(float(np.linalg.norm(across)), 1e-9)
    if not across.any():
        across = np.array([0.0, 1.0])
    return _aimed(pose, fore, np.append(np.sin(largest_bend) * across, np.cos(largest_bend)))
