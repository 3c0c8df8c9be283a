"""Ends and sights of limbs, on bodies where they are known."""

from __future__ import annotations

import numpy as np

from stereotrack_core.body.landmark_pose import pose_of_landmarks
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.model import body_model, landmarks
from stereotrack_core.body.pose import hanging_pose, t_pose
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.evaluation.limbs import limb_ends, seen_shares
from stereotrack_core.geometry.camera import Camera
from stereotrack_core.geometry.transform import RigidTransform
from stereotrack_core.recording.landmarks import LANDMARKS

BODY = body_model(proportions_of(None))
HIPS = np.array([0.0, 0.0, 0.95])


def camera(place, width=640):
    """Looks at the middle of the body from `place`."""
    place = np.asarray(place, float)
    z = HIPS + [0, 0, 0.2] - place
    z = z / np.linalg.norm(z)
    x = np.cross(z, [0, 0, 1.0])
    x = x / np.linalg.norm(x)
    turn = np.stack([x, np.cross(z, x), z])
    matrix = np.array([[400.0, 0, width / 2], [0, 400.0, 240], [0, 0, 1]])
    return Camera("c", width, 480, matrix, np.zeros(5), False, RigidTransform(turn, -turn @ place))


NORTH, EAST = camera((0, 3, 1.2)), camera((3, 0, 1.2))


def limb(name):
    return LIMBS.index(name)


def test_limbs_end_where_landmarks_are():
    points = landmarks(BODY, hanging_pose(HIPS))[None]
    ends = limb_ends(points)
    np.testing.assert_allclose(ends[0, limb("torso"), 0], HIPS, atol=1e-12)
    np.testing.assert_array_equal(
        ends[0, limb("left_forearm"), 1], points[0, LANDMARKS.index("left_hand")]
    )


def test_an_arm_behind_the_torso_is_not_seen_from_the_front():
    points = landmarks(BODY, t_pose(HIPS))
    open_arms = seen_shares(BODY, t_pose(HIPS), (NORTH, EAST))
    assert (open_arms[0] > 0.9).all()  # from the front all of a T pose is free
    assert open_arms[1, limb("left_upper_arm")] < 0.5  # from the right the torso hides the left arm
    at = {name: i for i, name in enumerate(LANDMARKS)}
    points[at["left_elbow"]] = points[at["left_shoulder"]] + [0.02, -0.22, -0.15]
    points[at["left_hand"]] = points[at["left_elbow"]] + [0.3, 0.0, -0.1]
    behind = seen_shares(BODY, pose_of_landmarks(points), (NORTH,))
    assert behind[0, limb("left_forearm")] < 0.4  # only the elbow looks out
    assert behind[0, limb("right_forearm")] > 0.9


def test_what_is_outside_the_image_is_not_seen():
    narrow = camera((0, 3, 1.2), width=120)
    shares = seen_shares(BODY, t_pose(HIPS), (narrow,))
    assert shares[0, limb("left_forearm")] == 0.0
    assert shares[0, limb("head")] > 0.9
