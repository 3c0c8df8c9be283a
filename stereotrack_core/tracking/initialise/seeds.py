"""Poses to begin from when nothing is known: postures, headings, heights."""

import numpy as np

from stereotrack_core.arrays import FloatArray
from stereotrack_core.body.model import BodyModel, placed_cones
from stereotrack_core.body.pose import Pose, hanging_pose, rotation_towards, t_pose
from stereotrack_core.body.skeleton import ARM_PARTS, HEAD, SHANKS, THIGHS, TORSO, UPPER_ARMS
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.geometry.upright import Z_UP, Upright

_CROWN = 98.5  # percentile of the height over the middle that is taken for the top of the head
_AROUND = 0.3  # metres around the middle in which the head is looked for; strays lie elsewhere
_HEADINGS = 12
_NEAR_MIDDLE = 0.35  # metres around the middle in which the top is; strays and hands lie elsewhere
_TOP, _BOTTOM = 98.5, 1.0  # percentiles of the heights taken for the upper and the lower end
_SOLE = 0.06  # metres from the ankle down to where data of a foot end


def t_pose_in_cloud(body: BodyModel, points: FloatArray, upright: Upright = Z_UP) -> Pose:
    """T pose facing north where points (N, 3), world, are: their middle, their top for the head."""
    points = upright.points(points)
    middle, heights = _middle_and_heights(points, _AROUND)
    cones = body.cones
    head = np.flatnonzero((cones["part"] == HEAD) & cones["round_end"])[0]
    crown = cones["origin"][head, 2] + cones["height"][head] + cones["r2"][head]
    top_over_hips = float(body.skeleton.joints[HEAD, 2] + crown)
    hips = np.append(middle, float(np.percentile(heights, _CROWN)) - top_over_hips)
    return _in_world(t_pose(hips), upright)


def _middle_and_heights(points: FloatArray, radius: float) -> tuple[FloatArray, FloatArray]:
    """Middle (2,) of points (N, 3), and heights of those that are so near to it, or of all."""
    middle: FloatArray = np.median(points[:, :2], axis=0)
    around = np.linalg.norm(points[:, :2] - middle, axis=1) < radius
    return middle, points[around, 2] if around.any() else points[:, 2]


def upright_pose(pose: Pose, upright: Upright) -> Pose:
    """A pose of the world as it is in the upright one."""
    return pose if upright == Z_UP else pose.turned(upright.rotation)


def _in_world(pose: Pose, upright: Upright) -> Pose:
    return pose if upright == Z_UP else pose.turned(upright.rotation.T)


# Trunk, thighs and shanks in the plane that the body bends in, radians from upright.
_POSTURES = np.radians(
    [
        [0.0, 0.0, 0.0],  # standing
        [35.0, 5.0, 5.0],  # bent
        [75.0, 10.0, 5.0],  # bent deeply
        [25.0, 70.0, 35.0],  # squatting
        [75.0, 60.0, 30.0],  # squatting bent deeply
    ]
)


def seeds_in(body: BodyModel, points: FloatArray, upright: Upright = Z_UP) -> list[Pose]:
    """Postures in all headings, put where points (N, 3), world, of one person are."""
    points = upright.points(points)
    middle, heights = _middle_and_heights(points, _NEAR_MIDDLE)
    top, bottom = np.percentile(heights, [_TOP, _BOTTOM])
    seeds = []
    for posture in _POSTURES:
        plain = _posed(*posture)
        low, high, centre = _extent(body, plain)
        heights_of_hips = {round(top - high, 2), round(bottom - low, 2)}
        for turn in 2.0 * np.pi * np.arange(_HEADINGS) / _HEADINGS:
            Rz = rotation_from_vector(np.array([0.0, 0.0, turn]))
            rotations = plain.rotations.copy()
            rotations[TORSO] = Rz @ plain.torso
            place = middle - (Rz @ centre)[:2]
            seeds += [Pose(np.append(place, z), rotations) for z in sorted(heights_of_hips)]
    return [_in_world(seed, upright) for seed in seeds]


def _posed(lean: float, thigh: float, shank: float) -> Pose:
    """A posture facing north with its hips at the origin; arms hang down."""
    torso = rotation_from_vector(np.array([-lean, 0.0, 0.0]))
    pose = hanging_pose(np.zeros(3), torso)
    rotations = pose.rotations.copy()
    down = np.array([0.0, 0.0, -1.0])
    ahead = np.array([0.0, np.sin(thigh), -np.cos(thigh)])
    behind = np.array([0.0, -np.sin(shank), -np.cos(shank)])
    for upper, lower in zip(THIGHS, SHANKS, strict=True):
        rotations[upper] = rotation_towards(rotations[upper], torso.T @ ahead)
        local = (torso @ rotations[upper]).T @ behind
        rotations[lower] = rotation_towards(rotations[lower], local)
    for part in UPPER_ARMS:
        rotations[part] = rotation_towards(rotations[part], torso.T @ down)
    return Pose(pose.position, rotations)


def _extent(body: BodyModel, pose: Pose) -> tuple[float, float, FloatArray]:
    """Lower end, upper end and middle (3,) of torso, head and legs, relative to the hips."""
    frames = body.frames(pose)
    cones = placed_cones(body, frames)[~np.isin(body.cones["part"], ARM_PARTS)]
    ends = cones["origin"] + cones["rotation"][:, :, 2] * cones["height"][:, None]
    radius = np.where(cones["round_end"], cones["r2"], 0.0)
    high = float(np.max(np.maximum(ends[:, 2] + radius, cones["origin"][:, 2])))
    low = float(np.min(ends[:, 2])) - _SOLE
    weight = cones["height"] * (cones["r1"] + cones["r2"])
    centre = np.average(0.5 * (ends + cones["origin"]), axis=0, weights=weight)
    return low, high, centre - pose.position
