"""Clouds and depth images of a body in a known pose."""

import numpy as np

from stereotrack_core.body.manifold import displaced
from stereotrack_core.body.model import placed_cones
from stereotrack_core.body.pose import Pose, hanging_pose, rotation_towards
from stereotrack_core.body.sampling import points_on_cones
from stereotrack_core.body.skeleton import TORSO
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.geometry.rotation import angle_between, rotation_from_vector
from tests.oracle.occlusion import solids_of

CAMERAS = np.array([[0.0, 3.0, 2.1], [3.0, 0.0, 2.1], [0.0, -3.0, 2.1], [-3.0, 0.0, 2.1]])


def pose_with_arms(right, right_fore, left, left_fore, place=(0.05, -0.1, 0.95)) -> Pose:
    """Upright pose; directions of the arms in the torso's frame, (x, y, z) to the right."""
    pose = hanging_pose(np.array(place))
    turned = pose.rotations.copy()
    for upper, fore, along, fore_along in ((3, 5, right, right_fore), (2, 4, left, left_fore)):
        turned[upper] = rotation_towards(turned[upper], _unit(along))
        turned[fore] = rotation_towards(np.eye(3), turned[upper].T @ _unit(fore_along))
    return Pose(pose.position, turned)


def moving_pose(k):
    """Pose in frame k of a person whose arms rise and fall."""
    return pose_with_arms(
        [1, 0.12 * k, -0.05 * k],
        [1, 0.3 * k, 0],
        [-1, 0.1 * k, 0.06 * k],
        [-1, 0.2 * k, 0.1 * k],
        place=(0.02 * k, 0.0, 0.95),
    )


def _unit(vector):
    return np.asarray(vector, dtype=float) / np.linalg.norm(vector)


POSES = {
    "t": pose_with_arms([1, 0, 0], [1, 0.05, 0], [-1, 0, 0], [-1, 0.05, 0]),
    "pointing": pose_with_arms([1, 0.6, -0.3], [0.2, 1, 0.3], [-0.9, 0.5, 0.4], [-0.3, 0.6, 1]),
    "reaching": pose_with_arms([0.8, 0.8, 0.2], [0.5, 1, 0.1], [-0.8, 0.1, -0.5], [-0.5, 1, -0.2]),
}


def disturbed(pose, joints, rng, position=0.03, torso=6.0, limbs=10.0) -> Pose:
    """The pose moved and turned at random; lengths in metres, angles in degrees."""
    delta = rng.normal(size=6 + 2 * len(joints))
    delta[:3] *= position / np.linalg.norm(delta[:3])
    delta[3:6] *= np.radians(torso) / np.linalg.norm(delta[3:6])
    tangents = delta[6:].reshape(-1, 2)
    tangents *= np.radians(limbs) / np.linalg.norm(tangents, axis=1, keepdims=True)
    return displaced(pose, delta, tuple(joints))


def surface_points(body, pose, count, rng, noise=0.0):
    """World points (N, 3), even over the outer surface of the body, disturbed by noise."""
    frames = body.frames(pose)
    cones = body.cones
    area = np.pi * (cones["r1"] + cones["r2"]) * cones["height"]
    cone = rng.choice(len(area), 2 * count, p=area / area.sum())
    h, angle = rng.random(len(cone)), 2 * np.pi * rng.random(len(cone))
    sampled = points_on_cones(cones, cone, h, angle)
    world = frames.apply(sampled.part, sampled.points)
    outside = np.ones(len(world), dtype=bool)
    for c, (turn, origin, r1, r2, height, s) in enumerate(solids_of(placed_cones(body, frames))):
        p = (world - origin) @ turn
        inner = np.hypot(p[:, 0], p[:, 1] / s) < r1 + (r2 - r1) * p[:, 2] / height - 1e-3
        outside &= ~(inner & (p[:, 2] > 0) & (p[:, 2] < height) & (cone != c))
    kept = world[outside][:count]
    return kept + noise * rng.normal(size=kept.shape)


def numerical_information(residuals, body, pose, joints):
    """What residuals say of a pose, by differences of what they predict."""
    n, step, total = 6 + 2 * len(joints), 1e-6, 0.0
    for residual in residuals:
        delta = step * np.concatenate([np.zeros((1, n)), np.eye(n), -np.eye(n)])
        predicted = residual.predicted(body.frames(displaced(pose, delta, joints)))
        H = (predicted[1 : n + 1] - predicted[n + 1 :]).T / (2 * step)
        weighed = H.T / residual.variance
        found = np.column_stack([weighed @ H, weighed @ (residual.measured - predicted[0])])
        total = total + found
    total = np.broadcast_to(total, (n, n + 1))
    return total[:, :n], total[:, n]


def cloud_of(points, frame=0) -> Cloud:
    """Cloud without the images it came from."""
    n = len(points)
    return Cloud(
        frame=frame,
        points=np.asarray(points, dtype=np.float64),
        view=np.zeros(n, dtype=np.int64),
        pixels=np.zeros((n, 2), dtype=np.int64),
        view_names=("N",),
        depths={},
    )


def clouds_of(body, pose, rng, count, points=2500, noise=0.005):
    """Successive clouds of a body that stands still."""
    return [cloud_of(surface_points(body, pose, points, rng, noise), k) for k in range(count)]


def angle_errors(body, found, true):
    """Angles (6,) in degrees between the limbs' directions of two poses."""
    a, b = (body.frames(pose).rotations[:6, :, 2] for pose in (found, true))
    return np.degrees(angle_between(a, b))


def turned(pose: Pose, degrees: float, place=(0.0, 0.0, 0.0)) -> Pose:
    R = rotation_from_vector(np.array([0.0, 0.0, np.radians(degrees)]))
    rotations = pose.rotations.copy()
    rotations[TORSO] = R @ pose.torso
    return Pose(R @ pose.position + place, rotations)


def moved(pose: Pose, by) -> Pose:
    return Pose(pose.position + np.asarray(by, dtype=float), pose.rotations)


def axis_off(found: Pose, true: Pose) -> float:
    """Degrees between the lines through the shoulders, whichever of them is left."""
    off = float(np.degrees(angle_between(found.torso[:, 0], true.torso[:, 0])))
    return min(off, 180.0 - off)
