"""Shoulders that move, and where the bones lie in the tracked body."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.body.angles import ALL_JOINTS, pose_of_state, state_of_pose
from stereotrack_core.body.manifold import columns_of, displaced, point_jacobian
from stereotrack_core.body.model import body_model, body_of_subject, landmarks
from stereotrack_core.body.offsets import NO_OFFSETS, offset_axes, offsets_by_landmark, offsets_of
from stereotrack_core.body.parameters import BodyParameters, BodyShape
from stereotrack_core.body.pose import Pose, hanging_pose, t_pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.skeleton import LEFT_CLAVICLE, PARTS, RIGHT_CLAVICLE
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.recording.description import Subject
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
    moved = body.frames(displaced(pose, near, ALL_JOINTS)).apply(part, points)
    along = np.sum(moved * directions, axis=2)
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


BODY = body_model(AVERAGE)


def some_pose(seed=0):
    rng = np.random.default_rng(seed)
    pose = hanging_pose(rng.normal(size=3), rotation_from_vector(rng.normal(size=3)))
    turns = rotation_from_vector(rng.normal(size=(len(PARTS), 3)))
    return Pose(pose.position, np.concatenate([pose.rotations[:1], (pose.rotations @ turns)[1:]]))


def test_without_offsets_nothing_changes():
    pose = some_pose()
    known = body_of_subject(Subject("P", **vars(AVERAGE)))
    np.testing.assert_array_equal(known.offsets, NO_OFFSETS)
    np.testing.assert_array_equal(landmarks(known, pose), landmarks(BODY, pose))


def test_offsets_of_the_trunk_turn_with_the_trunk():
    pose = some_pose()
    offset = (0.01, -0.02, 0.03)
    body = body_of_subject(Subject("P", **vars(AVERAGE), offsets={"left_hip": offset}))
    moved = landmarks(body, pose) - landmarks(BODY, pose)
    k = LANDMARKS.index("left_hip")
    np.testing.assert_allclose(moved[k], pose.torso @ offset, atol=1e-12)
    np.testing.assert_array_equal(np.delete(moved, k, axis=0), 0.0)


def test_both_arms_mirror_each_other():
    """The mirror image of a pose has the mirror images of its axes."""
    pose, mirror = some_pose(3), np.diag([-1.0, 1.0, 1.0])
    swapped = [
        PARTS.index(p.replace("left", "@").replace("right", "left").replace("@", "right"))
        for p in PARTS
    ]
    other = Pose(mirror @ pose.position, mirror @ pose.rotations[swapped] @ mirror)
    axes = offset_axes(BODY.frames(pose))[LANDMARKS.index("left_elbow")]
    image = offset_axes(BODY.frames(other))[LANDMARKS.index("right_elbow")]
    np.testing.assert_allclose(image, mirror @ axes, atol=1e-12)


def test_offsets_are_kept_by_name_and_with_another_surface():
    offsets = np.round(np.random.default_rng(1).normal(0.0, 0.01, (9, 3)), 5)
    by_name = offsets_by_landmark(offsets)
    np.testing.assert_array_equal(offsets_of(by_name), offsets)
    body = body_of_subject(Subject("P", offsets=by_name))
    wider = body.with_shape(BodyShape().replaced(torso_radius_low=0.2))
    np.testing.assert_array_equal(wider.offsets, offsets)
    assert wider.cones["r1"][0] == pytest.approx(0.2 * wider.skeleton.proportions.scale)
