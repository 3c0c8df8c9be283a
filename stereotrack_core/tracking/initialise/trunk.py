"""What speaks for and against a place of the whole body, and for the way that it faces.

Bodies look much the same from behind, but do not bend that way.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel, placed_cones
from stereotrack_core.body.pose import PartFrames, Pose
from stereotrack_core.body.skeleton import (
    ARM_PARTS,
    CLAVICLES,
    FOREARMS,
    HEAD,
    SHANKS,
    THIGHS,
    TORSO,
    UPPER_ARMS,
)
from stereotrack_core.body.surface import nearest_on_surface
from stereotrack_core.compiled import compiled
from stereotrack_core.depth.cloud import Cloud

_SQUARED_SCALE = 0.06**2
# Pixels of disparity, a little more than the matcher's errors.
_SEE_THROUGH_PX = 1.3  # from which a view looks through a place
_SUPPORT_PX = 0.9  # up to which it supports it
# Costs of a place, in data explained, as all of the search's costs.
_SEEN_THROUGH = 2.5  # that a view looks through; at most two views count
_UNSUPPORTED = 1.5  # that no view supports or hides
_UNKNOWN = np.zeros((0, 0), dtype=np.bool_)
_MAYBE_ARM = 0.5  # weight of data that an arm could explain
_HALF_TURN = np.diag([-1.0, -1.0, 1.0])
_PAIRS = (UPPER_ARMS, FOREARMS, THIGHS, SHANKS, CLAVICLES)
_LEGS = tuple(zip(THIGHS, SHANKS, strict=True))
# Costs of one knee bent forward, one thigh far behind, a trunk bent backward, two feet turned
# backward; in data explained, as those of the search for arms.
_KNEE, _THIGH, _LEAN, _FEET = 10.0, 5.0, 8.0, 8.0
_STRAIGHT = 0.2  # radians up to which a knee bent forward may be a straight one of another shape
# Cost of turning one's back on the only camera: people are filmed where one sees what they do.
_TURNED_AWAY = 20.0
_HEADLONG = 20.0  # cost of a trunk whose head hangs under its hips
_ANKLE, _ROUND_ANKLE = 0.06, 0.22  # metres over the ankle, and around it: data of a foot
_LEAST_ON_FOOT = 8


def unexplained_by_trunk(points: FloatArray, body: BodyModel, poses: Sequence[Pose]) -> FloatArray:
    """Mean (S,) of d^2 / (d^2 + 60 mm^2), d the distance of points from torso, head and legs.

    Points in reach of a shoulder count less, because arms may explain them.
    """
    rest = ~np.isin(body.cones["part"], ARM_PARTS)
    reach = sum(float(body.skeleton.lengths[part]) for part in (UPPER_ARMS[0], FOREARMS[0]))
    result = np.empty(len(poses))
    for k, pose in enumerate(poses):
        frames = body.frames(pose)
        placed = placed_cones(body, frames)[rest]
        squared = np.minimum(nearest_on_surface(points, placed, np.inf).distance, 1e3) ** 2
        unexplained = squared / (squared + _SQUARED_SCALE)
        off = [np.linalg.norm(points - frames.origins[part], axis=1) for part in UPPER_ARMS]
        result[k] = np.mean(np.where(np.minimum(*off) < reach, _MAYBE_ARM, 1.0) * unexplained)
    return result


def trunk_sight_cost(cloud: Cloud, body: BodyModel, poses: Sequence[Pose]) -> FloatArray:
    """Cost (S,) of places inside torso, head and legs where views see that nobody is."""
    places = np.concatenate([_places(body, body.frames(pose)) for pose in poses])
    # How many views look through each place, support it, hide it, or have no range there.
    seen = np.zeros((len(places), 4), dtype=np.int64)
    for depth in cloud.depths.values():
        g = depth.geometry
        pinhole = np.array([g.focal, g.c_x, g.c_y])
        in_camera = g.world_from_depth.inverse().apply(places)
        silhouette = _UNKNOWN if depth.silhouette is None else depth.silhouette
        limits = np.array([_SEE_THROUGH_PX, _SUPPORT_PX]) / g.disparity_scale
        _count_sight(in_camera, depth.range_z, silhouette, pinhole, limits, seen)
    through, supported, hidden, filled = seen.T
    nothing = (supported + hidden + filled == 0) & (through == 0)
    cost = _SEEN_THROUGH * np.minimum(through, 2) + _UNSUPPORTED * nothing
    return np.asarray(cost.reshape(len(poses), -1).sum(axis=1))


def _places(body: BodyModel, frames: PartFrames) -> FloatArray:
    """Places (M, 3), world, deep inside torso, head and legs."""
    length, half = body.skeleton.lengths, 0.35 * body.skeleton.proportions.shoulder_width
    in_torso = np.array([[x, 0.0, z] for z in (0.15, 0.5, 0.85) for x in (-half, 0.0, half)])
    in_torso *= [1.0, 1.0, length[TORSO]]
    along = [(HEAD, 0.5), (HEAD, 1.0)]
    along += [(part, t) for part in THIGHS for t in (0.4, 0.9)]
    along += [(part, 0.5) for part in SHANKS]
    parts = np.array([part for part, _ in along])
    reach = np.array([t * length[part] for part, t in along])
    on_limbs = frames.origins[parts] + reach[:, None] * frames.rotations[parts, :, 2]
    trunk = in_torso @ frames.rotations[TORSO].T + frames.origins[TORSO]
    return np.concatenate([trunk, on_limbs])


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

    Pose, data (N, 3) and optical centres (V, 3) are in a world whose z points up. Toes lie in front
    of the ankles; nothing is said where no foot is seen, nor by cameras that stand all around.
    """
    frames = body.frames(pose)
    feet = sum(
        0.25 * _FEET * (1.0 - float(np.clip(ahead / 0.04, -1.0, 1.0)))
        for ahead in feet_ahead(body, frames, points)
    )
    return legs_cost(frames) + feet + lean_cost(frames) + away_cost(frames, cameras)


def legs_cost(frames: PartFrames) -> float:
    """Knees bend backward, and thighs rise to the front."""
    total, torso = 0.0, frames.rotations[TORSO]
    for thigh, shank in _LEGS:
        along = torso.T @ frames.rotations[[thigh, shank], :, 2].T
        swing = np.arctan2(along[1], -along[2])
        bend = float((swing[0] - swing[1] + np.pi) % (2.0 * np.pi) - np.pi)
        total += _KNEE * float(np.clip((-bend - _STRAIGHT) / 0.25, 0.0, 2.0))
        total += _THIGH * float(np.clip((-swing[0] - 0.5) / 0.3, 0.0, 2.0))
    return total


def lean_cost(frames: PartFrames) -> float:
    """Trunks bend to the front."""
    forward = _on_floor(frames)
    up = frames.rotations[TORSO, :, 2]
    lean = float(np.degrees(np.arctan2(up @ forward, max(up[2], 1e-3))))
    headlong = _HEADLONG * float(np.clip((-0.15 - up[2]) / 0.3, 0.0, 2.0))
    return headlong + _LEAN * float(np.clip((-lean - 12.0) / 12.0, 0.0, 3.0))


def feet_ahead(body: BodyModel, frames: PartFrames, points: FloatArray) -> list[float]:
    """Metres by which the data (N, 3), z up, of each foot that has some lie before its ankle."""
    forward, found = _on_floor(frames), []
    for _, shank in _LEGS:
        along = frames.rotations[shank, :, 2]
        ankle = frames.origins[shank] + body.skeleton.lengths[shank] * along
        off = points[points[:, 2] < ankle[2] + _ANKLE] - ankle
        near = np.hypot(off[:, 0], off[:, 1]) < _ROUND_ANKLE
        if np.count_nonzero(near) >= _LEAST_ON_FOOT:
            found.append(float(np.median(off[near] @ forward)))
    return found


def away_cost(frames: PartFrames, cameras: FloatArray) -> float:
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
    return np.asarray(ahead / max(float(np.linalg.norm(ahead)), 1e-6))


@compiled()
def _count_sight(
    points: Any, image: Any, silhouette: Any, pinhole: Any, limits: Any, seen: Any
) -> None:
    """Add to the counters (M, 4) how one view judges every point.

    `points` (M, 3) are in the frame of the depth camera; `image` (H, W) are ranges along z, NaN
    where not known; `silhouette` is (0, 0) where it is not known; `limits` (2,) are the
    differences of inverse range for seeing through and for support.
    """
    height, width = image.shape
    see_through, support = limits[0], limits[1]
    for i in range(points.shape[0]):
        z = points[i, 2]
        if z < 0.1:
            continue
        u = round(pinhole[0] * points[i, 0] / z + pinhole[1])
        v = round(pinhole[0] * points[i, 1] / z + pinhole[2])
        if u < 0 or v < 0 or u >= width or v >= height:
            continue
        measured = image[v, u]
        if not measured > 0.0:
            if silhouette.shape[0] > 0:
                seen[i, 3 if silhouette[v, u] else 0] += 1
            continue
        difference = 1.0 / measured - 1.0 / z
        if difference < -see_through:
            seen[i, 0] += 1
        elif abs(difference) < support:
            seen[i, 1] += 1
        elif difference > 0.0:
            seen[i, 2] += 1
