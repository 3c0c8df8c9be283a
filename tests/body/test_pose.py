"""Forward kinematics, poses, and the angles of their states."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.body.angles import (
    ALL_JOINTS,
    MIRROR,
    THESIS_JOINTS,
    angles_of_rotation,
    euler_rotation,
    joint_angles,
    joint_rotation,
    pose_of_state,
    state_of_pose,
)
from stereotrack_core.body.model import body_model, landmarks
from stereotrack_core.body.pose import Pose, rotation_towards, t_pose
from stereotrack_core.body.proportions import AVERAGE, Proportions
from stereotrack_core.body.skeleton import LEFT_PARTS, PARTS
from stereotrack_core.geometry.rotation import angle_between
from stereotrack_core.recording.landmarks import LANDMARKS
from tests.body.poses import SPECIAL_POSES, random_pose, rotations, thesis_state
from tests.oracle.kinematics import landmarks_of_rotations, landmarks_of_state, turn

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


def test_the_t_pose_faces_north_with_the_right_arm_in_the_east(body):
    place = np.array([0.3, -0.2, 0.9])
    points = dict(zip(LANDMARKS, landmarks(body, t_pose(place)), strict=True))
    shoulders = place + [0, 0, AVERAGE.torso_length]
    reach = AVERAGE.upper_arm_length + AVERAGE.elbow_to_hand
    half = 0.5 * AVERAGE.shoulder_width
    np.testing.assert_allclose(points["right_hand"], shoulders + [half + reach, 0, 0], atol=1e-12)
    np.testing.assert_allclose(points["left_hand"], shoulders - [half + reach, 0, 0], atol=1e-12)
    np.testing.assert_allclose(points["head"], shoulders + [0, 0, AVERAGE.shoulder_to_head])


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


ANGLE = st.floats(-np.pi, np.pi)


@given(alpha=ANGLE, beta=ANGLE, gamma=ANGLE)
def test_the_rotation_is_active_and_right_handed(alpha, beta, gamma):
    expected = (turn("z", gamma) @ turn("y", beta) @ turn("x", alpha))[:3, :3]
    found = euler_rotation(np.array(alpha), np.array(beta), np.array(gamma))
    np.testing.assert_allclose(found, expected, atol=1e-14)


@given(alpha=ANGLE, gamma=ANGLE, off=st.sampled_from([0.0, 1e-15, 1e-10, 1e-5]), up=st.booleans())
def test_the_rotation_comes_back_in_the_gimbals_lock_too(alpha, gamma, off, up):
    beta = (np.pi / 2 - off) * (1 if up else -1)
    rotation = euler_rotation(*np.array([alpha, beta, gamma]))
    again = euler_rotation(*np.moveaxis(angles_of_rotation(rotation), -1, 0))
    np.testing.assert_allclose(again, rotation, atol=1e-12)


@pytest.mark.parametrize("part", ALL_JOINTS)
def test_every_direction_of_a_limb_has_its_angles(rng, part):
    axes = np.concatenate([np.eye(3), -np.eye(3), rotations(rng, 200)[..., 2]])
    alpha, beta = joint_angles(part, axes)
    np.testing.assert_allclose(joint_rotation(part, alpha, beta)[..., 2], axes, atol=1e-14)


@pytest.mark.parametrize("right", [part for part in ALL_JOINTS if PARTS[part].startswith("right")])
def test_left_limbs_mirror_right_ones(rng, right):
    left = PARTS.index(PARTS[right].replace("right", "left"))
    assert left in LEFT_PARTS
    alpha, beta = rng.uniform(-np.pi, np.pi, (2, 50))
    mirrored = MIRROR @ joint_rotation(right, alpha, beta) @ MIRROR
    np.testing.assert_allclose(joint_rotation(left, alpha, beta), mirrored, atol=1e-15)


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=50, deadline=None)
def test_a_mirrored_state_gives_mirrored_landmarks(body, seed):
    x = thesis_state(np.random.default_rng(seed))
    mirrored = np.concatenate([x[:6] * [-1, 1, 1, 1, -1, -1], x[10:14], x[6:10]])
    points = dict(zip(LANDMARKS, landmarks(body, pose_of_state(x, THESIS_JOINTS)), strict=True))
    reflected = landmarks(body, pose_of_state(mirrored, THESIS_JOINTS))
    other = {"left": "right", "right": "left", "head": "head"}
    for name, point in zip(LANDMARKS, reflected, strict=True):
        side, _, rest = name.partition("_")
        twin = f"{other[side]}_{rest}" if rest else name
        np.testing.assert_allclose(point, points[twin] @ MIRROR, atol=1e-13)


@pytest.mark.parametrize("name", [*SPECIAL_POSES, "random"])
def test_landmarks_are_always_reproduced(rng, body, name):
    poses = [SPECIAL_POSES[name]] if name in SPECIAL_POSES else [random_pose(rng) for _ in range(9)]
    for pose in poses:
        again = pose_of_state(state_of_pose(pose, ALL_JOINTS), ALL_JOINTS)
        np.testing.assert_allclose(landmarks(body, again), landmarks(body, pose), atol=1e-12)
