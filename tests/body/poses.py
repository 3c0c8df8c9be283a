"""Poses, states and single cones for the tests."""

import numpy as np

from stereotrack_core.body.model import CONE
from stereotrack_core.body.pose import Pose, hanging_pose, rotation_towards, t_pose
from stereotrack_core.body.skeleton import PARTS, TORSO
from stereotrack_core.geometry.rotation import rotation_from_vector


def rotations(rng, *shape):
    """Random rotation matrices (*shape, 3, 3), up to half a turn."""
    vector = rng.normal(size=(*shape, 3))
    vector *= rng.uniform(0, np.pi, (*shape, 1)) / np.linalg.norm(vector, axis=-1, keepdims=True)
    return rotation_from_vector(vector)


def random_pose(rng):
    """Every part turned at random, arms rolled too."""
    return Pose(rng.normal(size=3), rotations(rng, len(PARTS)))


def thesis_state(rng, spread=1.0):
    """14 numbers without limits to what a person can do."""
    return np.concatenate([rng.normal(size=3), spread * rng.uniform(-np.pi, np.pi, 11)])


def with_direction(pose, part, direction):
    """The pose with one part's z axis along `direction` in its parent's frame."""
    turned = pose.rotations.copy()
    unit = np.asarray(direction, dtype=float)
    turned[part] = rotation_towards(turned[part], unit / np.linalg.norm(unit))
    return Pose(pose.position, turned)


def arms_towards(direction):
    """Upright, both upper arms towards the same direction of the torso's frame."""
    pose = hanging_pose(np.array([0.2, -0.1, 0.95]))
    for part in (2, 3):
        pose = with_direction(pose, part, direction)
    return pose


def folded_pose():
    """Elbows bent by 150 degrees."""
    pose = t_pose(np.zeros(3))
    bend = np.radians(150.0)
    for part in (4, 5):
        pose = with_direction(pose, part, [0.0, np.sin(bend), np.cos(bend)])
    return pose


SPECIAL_POSES = {
    "hanging": hanging_pose(np.array([0.0, 0.0, 0.95])),
    "t": t_pose(np.array([0.3, -0.2, 0.95])),
    "forward": arms_towards([0.0, 1.0, 0.0]),
    "backward": arms_towards([0.0, -1.0, 0.0]),
    "raised": arms_towards([0.0, 0.0, 1.0]),
    "right": arms_towards([1.0, 0.0, 0.0]),
    "folded": folded_pose(),
    "lying": t_pose(np.zeros(3), rotation_from_vector(np.array([0.0, np.pi / 2, 0.0]))),
}
"""Places where angles or axes coincide."""


def single_cone(rng, r1, r2, height, s=1.0, round_end=False):
    """One cone somewhere in the world, and the function from its frame to the world."""
    turn, origin = rotations(rng), rng.normal(size=3)
    placed = np.zeros(1, dtype=CONE)
    placed[0] = TORSO, turn, origin, r1, r2, height, s, round_end, (0.0, 0.0)
    return placed, turn, origin
