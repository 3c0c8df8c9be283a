"""Poses to begin from: what triangulated landmarks show, and the usual pose for the rest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from stereotrack_core.annotation.fit.residuals import Clicks
from stereotrack_core.annotation.landmark_set import NINE, LandmarkSet
from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel
from stereotrack_core.body.pose import Pose, hanging_pose, rotation_towards
from stereotrack_core.body.skeleton import FOREARMS, HEAD, PARENTS, PARTS, TORSO, UPPER_ARMS
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.triangulation import Sightings, nearest_to_rays, point_of_sightings

TRUNK = ("left_shoulder", "right_shoulder", "head", "left_hip", "right_hip")
"""Landmarks that tell where the trunk is."""

_CHAINS = {
    UPPER_ARMS[0]: "left_elbow",
    UPPER_ARMS[1]: "right_elbow",
    FOREARMS[0]: "left_hand",
    FOREARMS[1]: "right_hand",
    HEAD: "head",
}
"""The landmark at the far end of a part."""

_LEAST_SIGMA = 3.0
"""Pixels; calibrations are no better than that."""

_DISTANCE = 3.0
"""Metres in front of a lone camera at which somebody is looked for."""


def watched_place(cameras: Mapping[str, Camera]) -> FloatArray:
    """The point (3,), world, that the cameras look at together."""
    places = [camera.world_from_camera for camera in cameras.values()]
    if not places:
        return np.zeros(3)
    origins = np.array([place.translation for place in places])
    axes = np.array([place.rotation[:, 2] for place in places])
    point = nearest_to_rays(origins, axes)
    ahead = np.einsum("vi,vi->v", point - origins, axes) > 0.0
    if np.isfinite(point).all() and ahead.all():
        return point
    middle: FloatArray = (origins + _DISTANCE * axes).mean(axis=0)
    return middle


def standing(body: BodyModel, middle: FloatArray, yaw: float = 0.0) -> Pose:
    """The usual pose: upright, arms hanging, the middle of the trunk at a place (3,)."""
    torso = rotation_from_vector(np.array([0.0, 0.0, yaw]))
    half = 0.5 * body.skeleton.proportions.torso_length
    return hanging_pose(middle - np.array([0.0, 0.0, half]), torso)


def triangulated(clicks: Clicks, landmarks: int) -> FloatArray:
    """Points (L, 3), world, that most clicks of a frame agree with; NaN where there are none."""
    points = np.full((landmarks, 3), np.nan)
    for landmark in range(landmarks):
        own = clicks.landmark == landmark
        found = point_of_sightings(
            Sightings(
                clicks.rotations[own],
                clicks.translations[own],
                clicks.normalised[own],
                clicks.raw_from_normalised[own],
                np.maximum(clicks.sigma[own], _LEAST_SIGMA),
            )
        )
        if found is not None:
            points[landmark] = found.world
    return points


def filled_over_time(points: FloatArray) -> FloatArray:
    """Points (F, L, 3) with what is missing between known frames; NaN where never known."""
    filled = points.copy()
    frames = np.arange(len(points))
    for i in range(points.shape[1]):
        known = np.isfinite(points[:, i]).all(axis=1)
        if known.any():
            for axis in range(3):
                filled[:, i, axis] = np.interp(frames, frames[known], points[known, i, axis])
    return filled


def pose_at(points: FloatArray, body: BodyModel, landmark_set: LandmarkSet, usual: Pose) -> Pose:
    """Pose that shows the known points (L, 3) of the set; what they do not tell is as usual.

    Parameters
    ----------
    points : (L, 3) float64, world, metres
        NaN where not known.
    """
    known = {
        name: point
        for name, point in zip(landmark_set.names, points, strict=True)
        if name in NINE.names and np.isfinite(point).all()
    }
    pose = _trunk_at(known, body, usual)
    for part, name in _CHAINS.items():
        if name in known:
            frames = body.frames(pose)
            away = known[name] - frames.origins[part]
            length = float(np.linalg.norm(away))
            if length > 1e-3:
                local = frames.rotations[PARENTS[part]].T @ (away / length)
                rotations = pose.rotations.copy()
                rotations[part] = rotation_towards(usual.rotations[part], local)
                pose = Pose(pose.position, rotations)
    return pose


def _trunk_at(known: Mapping[str, FloatArray], body: BodyModel, usual: Pose) -> Pose:
    names = [name for name in TRUNK if name in known]
    if not names:
        ends = [point for name, point in known.items() if name not in TRUNK]
        if not ends:
            return usual
        middle = 0.5 * body.skeleton.proportions.torso_length * usual.torso[:, 2]
        return Pose(np.mean(ends, axis=0) - middle, usual.rotations)
    rest = NINE.places(body, body.frames(usual))
    own = np.array([rest[NINE.names.index(name)] for name in names])
    seen = np.array([known[name] for name in names])
    turn = _turn(own, seen) if len(names) > 2 else np.eye(3)
    rotations = usual.rotations.copy()
    rotations[TORSO] = turn @ usual.torso
    shift = seen.mean(axis=0) - turn @ (own.mean(axis=0) - usual.position)
    return Pose(shift, rotations)


def _turn(own: FloatArray, seen: FloatArray) -> FloatArray:
    """Rotation (3, 3) that brings `own` (N, 3) next to `seen` (Kabsch)."""
    u, _, vt = np.linalg.svd((seen - seen.mean(axis=0)).T @ (own - own.mean(axis=0)))
    result: FloatArray = u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt
    return result


def without_twists(poses: Sequence[Pose]) -> list[Pose]:
    """The same poses, parts turned about their own axes as little as can be between frames.

    How a part is turned about its own axis is no part of the state, but its numbers are counted
    along axes that turn with it.
    """
    found: list[Pose] = []
    for pose in poses:
        if found:
            rotations = pose.rotations.copy()
            before = found[-1].rotations
            turned = pose.rotations
            for part in range(1, len(PARTS)):
                parent = PARENTS[part]
                undone = np.eye(3)
                if parent != TORSO:
                    undone = rotations[parent].T @ turned[parent]
                direction = undone @ turned[part][:, 2]
                rotations[part] = rotation_towards(before[part], direction)
            pose = replace(pose, rotations=rotations)
        found.append(pose)
    return found
