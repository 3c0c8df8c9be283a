"""A trunk that is seen as a whole, in part, and not at all."""

import numpy as np

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.depth.points import Volume
from stereotrack_core.tracking.initialise.people import (
    depth_inside,
    share_at_sides,
    trunk_support,
)
from tests.tracking.scenes import CAMERAS, POSES, surface_points

BODY = body_model(AVERAGE)
POSE = POSES["t"]


def test_support_falls_with_what_is_cut_away(rng):
    points = surface_points(BODY, POSE, 4000, rng)
    whole = trunk_support(BODY, POSE, points, CAMERAS)
    half = trunk_support(BODY, POSE, points[points[:, 0] < POSE.position[0]], CAMERAS)
    assert whole > 0.9
    assert 0.3 < half < 0.7
    assert trunk_support(BODY, POSE, np.empty((0, 3)), CAMERAS) == 0.0


def test_one_camera_expects_its_own_side_only(rng):
    points = surface_points(BODY, POSE, 4000, rng)
    camera = np.array([[0.0, 3.0, 1.5]])
    front = points[points[:, 1] > POSE.position[1] + 0.02]
    back = points[points[:, 1] < POSE.position[1] - 0.02]
    assert trunk_support(BODY, POSE, front, camera) > 0.8
    assert trunk_support(BODY, POSE, back, camera) < 0.3


def test_points_at_the_sides_are_counted(rng):
    volume = Volume(np.array([-1.8, -1.8, 0.0]), np.array([1.8, 1.8, 2.4]))
    within = rng.uniform([-1.0, -1.0, 0.0], [1.0, 1.0, 2.4], (300, 3))
    at_side = within[:100].copy()
    at_side[:, 0] = 1.78
    assert share_at_sides(within, volume) == 0.0
    assert share_at_sides(np.concatenate([within, at_side]), volume) == 0.25
    assert share_at_sides(np.empty((0, 3)), volume) == 0.0


def test_depth_inside_knows_sides_alone():
    volume = Volume(np.array([-1.8, -1.8, 0.0]), np.array([1.8, 1.8, 2.4]))
    points = np.array([[0.0, 0.0, 2.39], [1.7, 0.5, 1.0], [0.0, -2.0, 1.0]])
    assert np.allclose(depth_inside(points, volume), [1.8, 0.1, -0.2])
