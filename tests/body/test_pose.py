"""Forward kinematics and poses."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.body.angles import THESIS_JOINTS, pose_of_state
from stereotrack_core.body.model import body_model, landmarks
from stereotrack_core.body.pose import Pose, hanging_pose, rotation_towards, t_pose
from stereotrack_core.body.proportions import AVERAGE, Proportions
from stereotrack_core.body.skeleton import PARTS
from stereotrack_core.geometry.rotation import angle_between, rotation_from_vector
from stereotrack_core.recording.landmarks import LANDMARKS
from tests.body.poses import random_pose, rotations, thesis_state
from tests.oracle.kinematics import landmarks_of_rotations, landmarks_of_state

TALL = Proportions(0.41, 0.25, 0.53, 0.31, 0.28, 0.2, 0.22)


@pytest.mark.parametrize("proportions", [AVERAGE, TALL])
def test_landmarks_of_a_state_are_those_of_chained_matrices(rng, proportions):
    body = body_model(proportions)
    for _ in range(20):
        x = thesis_state(rng)
        expected = landmarks_of_state(x, proportions)
        found = landmarks(body, pose_of_state(x, THESIS_JOINTS))
        np.testing.assert_allclose(found, [expected[name] for name in LANDMARKS], atol=1e-12)


def test_landmarks_of_any_rotations_are_those_of_chained_matrices(rng, body):
    for _ in range(20):
        pose = random_pose(rng)
        turned = dict(zip(PARTS, pose.rotations, strict=True))
        expected = landmarks_of_rotations(pose.position, turned, AVERAGE)
        found = landmarks(body, pose)
        np.testing.assert_allclose(found, [expected[name] for name in LANDMARKS], atol=1e-12)


def test_stacked_poses_are_the_single_ones(rng, body):
    poses = [random_pose(rng) for _ in range(5)]
    stack = Pose(np.array([p.position for p in poses]), np.array([p.rotations for p in poses]))
    together = landmarks(body, stack)
    for i, pose in enumerate(poses):
        np.testing.assert_allclose(together[i], landmarks(body, pose), atol=1e-14)
        np.testing.assert_array_equal(stack[i].rotations, pose.rotations)


def test_points_of_parts_are_put_where_their_parts_are(rng, body):
    pose = random_pose(rng)
    frames = body.frames(pose)
    part = rng.integers(0, len(PARTS), 30)
    points = rng.normal(size=(30, 3))
    expected = [frames.rotations[k] @ points[i] + frames.origins[k] for i, k in enumerate(part)]
    np.testing.assert_allclose(frames.apply(part, points), expected, atol=1e-14)


def test_the_t_pose_faces_north_with_the_right_arm_in_the_east(body):
    place = np.array([0.3, -0.2, 0.9])
    points = dict(zip(LANDMARKS, landmarks(body, t_pose(place)), strict=True))
    shoulders = place + [0, 0, AVERAGE.torso_length]
    reach = AVERAGE.upper_arm_length + AVERAGE.elbow_to_hand
    half = 0.5 * AVERAGE.shoulder_width
    np.testing.assert_allclose(points["right_hand"], shoulders + [half + reach, 0, 0], atol=1e-12)
    np.testing.assert_allclose(points["left_hand"], shoulders - [half + reach, 0, 0], atol=1e-12)
    np.testing.assert_allclose(points["head"], shoulders + [0, 0, AVERAGE.shoulder_to_head])


def test_hanging_arms_hang_beside_a_turned_torso(rng, body):
    torso = rotations(rng)
    points = dict(zip(LANDMARKS, landmarks(body, hanging_pose(np.zeros(3), torso)), strict=True))
    for side in ("left", "right"):
        down = points[f"{side}_hand"] - points[f"{side}_shoulder"]
        assert angle_between(down, -torso[:, 2]) < 1e-7


@settings(max_examples=100, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    off=st.sampled_from([0.0, 1e-16, 1e-12, 1e-9, 1e-6, 1e-4, 0.1, 1.0]),
    opposite=st.booleans(),
)
def test_turning_towards_a_direction_is_the_smallest_turn(seed, off, opposite):
    rng = np.random.default_rng(seed)
    rotation = rotations(rng)
    aside = rotation[:, :2] @ rng.normal(size=2)
    axis = -rotation[:, 2] if opposite else rotation[:, 2]
    direction = np.cos(off) * axis + np.sin(off) * aside / np.linalg.norm(aside)
    turned = rotation_towards(rotation, direction)
    np.testing.assert_allclose(turned[:, 2], direction, atol=1e-11)
    np.testing.assert_allclose(turned @ turned.T, np.eye(3), atol=1e-11)
    assert np.linalg.det(turned) == pytest.approx(1.0)
    turn = rotation.T @ turned
    cosine = np.clip(0.5 * (np.trace(turn) - 1.0), -1.0, 1.0)
    assert np.arccos(cosine) == pytest.approx(
        float(angle_between(rotation[:, 2], direction)), abs=1e-5
    )


def test_many_are_turned_at_once(rng):
    many, towards = rotations(rng, 7), rotations(rng, 7)[..., 2]
    together = rotation_towards(many, towards)
    for i in range(7):
        np.testing.assert_allclose(together[i], rotation_towards(many[i], towards[i]), atol=1e-14)


def test_half_a_turn_is_made_about_the_rotations_own_x():
    turned = rotation_towards(np.eye(3), np.array([0.0, 0.0, -1.0]))
    np.testing.assert_allclose(turned, rotation_from_vector(np.array([np.pi, 0, 0])), atol=1e-15)
