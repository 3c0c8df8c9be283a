"""The thesis's angle chain."""

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
    state_names,
    state_of_pose,
)
from stereotrack_core.body.model import landmarks
from stereotrack_core.body.skeleton import LEFT_PARTS, PARTS
from stereotrack_core.recording.landmarks import LANDMARKS
from tests.body.poses import SPECIAL_POSES, random_pose, rotations, thesis_state
from tests.oracle.kinematics import turn

ANGLE = st.floats(-np.pi, np.pi)


def _printed(alpha, beta, gamma):
    """R(alpha, beta, gamma) as section 2.5 prints it, in active elementary rotations."""
    return (turn("z", -gamma) @ turn("y", beta) @ turn("x", -alpha))[:3, :3]


@given(alpha=ANGLE, beta=ANGLE, gamma=ANGLE)
def test_the_rotation_is_active_and_right_handed(alpha, beta, gamma):
    expected = (turn("z", gamma) @ turn("y", beta) @ turn("x", alpha))[:3, :3]
    found = euler_rotation(np.array(alpha), np.array(beta), np.array(gamma))
    np.testing.assert_allclose(found, expected, atol=1e-14)


@given(alpha=ANGLE, beta=ANGLE, gamma=ANGLE)
def test_the_printed_chain_gives_the_active_rotation_after_conversion(alpha, beta, gamma):
    active = np.array([alpha, beta, gamma])
    np.testing.assert_allclose(_printed(-alpha, beta, -gamma), euler_rotation(*active), atol=1e-14)


@given(alpha=ANGLE, beta=st.floats(-1.5, 1.5), gamma=ANGLE)
def test_angles_come_back_away_from_the_gimbals_lock(alpha, beta, gamma):
    found = angles_of_rotation(euler_rotation(*np.array([alpha, beta, gamma])))
    apart = np.angle(np.exp(1j * (found - [alpha, beta, gamma])))
    np.testing.assert_allclose(apart, 0.0, atol=1e-12)


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


@pytest.mark.parametrize("joints", [THESIS_JOINTS, ALL_JOINTS])
def test_states_come_back_away_from_the_lock(rng, joints):
    x = rng.uniform(-1.5, 1.5, (100, 6 + 2 * len(joints)))
    again = state_of_pose(pose_of_state(x, joints), joints)
    np.testing.assert_allclose(again, x, atol=1e-10)
    assert len(state_names(joints)) == x.shape[1] == len(set(state_names(joints)))


@pytest.mark.parametrize("name", [*SPECIAL_POSES, "random"])
def test_landmarks_are_always_reproduced(rng, body, name):
    poses = [SPECIAL_POSES[name]] if name in SPECIAL_POSES else [random_pose(rng) for _ in range(9)]
    for pose in poses:
        again = pose_of_state(state_of_pose(pose, ALL_JOINTS), ALL_JOINTS)
        np.testing.assert_allclose(landmarks(body, again), landmarks(body, pose), atol=1e-12)


def test_parts_without_a_joint_in_the_state_keep_zero_angles(rng, body):
    pose = pose_of_state(np.zeros(14), THESIS_JOINTS)
    for part, down in ((1, 1), (2, -1), (4, 1), (6, -1), (8, 1)):
        np.testing.assert_array_equal(pose.rotations[part, :, 2], [0, 0, down])
