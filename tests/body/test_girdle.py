"""Shoulders that are lifted, pushed forward and drawn back."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.body.angles import ALL_JOINTS, pose_of_state, state_of_pose
from stereotrack_core.body.manifold import columns_of, displaced, point_jacobian, points_along
from stereotrack_core.body.model import body_model, landmarks
from stereotrack_core.body.parameters import BodyParameters
from stereotrack_core.body.pose import hanging_pose, t_pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.skeleton import CLAVICLES, LEFT_CLAVICLE, PARTS, RIGHT_CLAVICLE
from stereotrack_core.recording.landmarks import LANDMARKS
from tests.body.poses import random_pose

ANGLES = len(ALL_JOINTS) * 2 + 6


def _with(part, alpha, beta):
    """A T pose at the origin with one clavicle turned, degrees."""
    x = state_of_pose(t_pose(np.zeros(3)), ALL_JOINTS)
    at = 6 + 2 * ALL_JOINTS.index(part)
    x[at : at + 2] = np.radians([alpha, beta])
    return pose_of_state(x, ALL_JOINTS)


def _moved(body, part, alpha, beta):
    """How far each landmark is from where it rests."""
    away = landmarks(body, _with(part, alpha, beta)) - landmarks(body, t_pose(np.zeros(3)))
    return dict(zip(LANDMARKS, away, strict=True))


@pytest.mark.parametrize(("part", "side"), [(LEFT_CLAVICLE, "left"), (RIGHT_CLAVICLE, "right")])
def test_the_angles_draw_back_and_lower_either_shoulder_and_take_the_arm_along(body, part, side):
    for angles, axis in (((10.0, 0.0), 1), ((0.0, 10.0), 2)):
        away = _moved(body, part, *angles)
        shoulder = away[f"{side}_shoulder"]
        assert shoulder[axis] == pytest.approx(
            -0.88 * 0.5 * AVERAGE.shoulder_width * np.sin(np.radians(10.0))
        )
        for name in (f"{side}_elbow", f"{side}_hand"):
            np.testing.assert_allclose(away[name], shoulder, atol=1e-15)
        for name, other in away.items():
            assert (name.startswith(side) and "hip" not in name) or np.all(other == 0.0)


def test_shoulders_at_rest_are_exactly_where_fixed_ones_are(body, rng):
    pose = hanging_pose(rng.normal(size=3), random_pose(rng).torso)
    fixed = body_model(AVERAGE, BodyParameters(girdle=False))
    np.testing.assert_array_equal(landmarks(body, pose), landmarks(fixed, pose))


def test_only_a_body_whose_shoulders_move_has_clavicles_in_its_state(body, legless):
    assert body.joints == ALL_JOINTS
    assert not set(CLAVICLES) & set(legless.joints)
    legs_only = body_model(AVERAGE, BodyParameters(girdle=False))
    assert legs_only.joints == tuple(j for j in ALL_JOINTS if j not in CLAVICLES)


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_derivatives_of_points_of_all_parts_are_differences(seed):
    rng, body, step = np.random.default_rng(seed), body_model(AVERAGE), 1e-6
    pose, columns = random_pose(rng), columns_of(ALL_JOINTS)
    part = rng.integers(0, len(PARTS), 30)
    points, directions = rng.normal(size=(2, 30, 3))
    frames = body.frames(pose)
    J = point_jacobian(frames.apply(part, points), directions, part, frames, columns)
    near = np.concatenate([step * np.eye(ANGLES), -step * np.eye(ANGLES)])
    along = points_along(points, directions, part, body.frames(displaced(pose, near, ALL_JOINTS)))
    expected = (along[:ANGLES] - along[ANGLES:]).T / (2 * step)
    np.testing.assert_allclose(J, expected, atol=1e-7)


@settings(max_examples=40, deadline=None)
@given(angles=st.lists(st.floats(-1.2, 1.2), min_size=4, max_size=4))
def test_the_state_gives_the_clavicles_angles_again(angles):
    x = state_of_pose(t_pose(np.zeros(3)), ALL_JOINTS)
    x[-4:] = angles
    np.testing.assert_allclose(
        state_of_pose(pose_of_state(x, ALL_JOINTS), ALL_JOINTS), x, atol=1e-12
    )
