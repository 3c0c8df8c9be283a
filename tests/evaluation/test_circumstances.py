"""Distances, speeds and sights of limbs, on bodies where they are known."""

from __future__ import annotations

import numpy as np
import pytest

from stereotrack_core.body.landmark_pose import pose_of_landmarks
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.model import body_model, landmarks
from stereotrack_core.body.pose import t_pose
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.errors import Cancelled
from stereotrack_core.evaluation.circumstances import (
    circumstances_of,
    seen_shares,
    views_that_see,
)
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


def test_the_nearest_camera_counts_from_the_middle_of_the_limb():
    points = landmarks(BODY, t_pose(HIPS))[None]
    found = circumstances_of(np.array([0]), points, (NORTH, EAST), 10.0)
    right = points[0, [LANDMARKS.index("right_elbow"), LANDMARKS.index("right_hand")]].mean(axis=0)
    expected = np.linalg.norm(right - [3, 0, 1.2])
    assert found.distance[0, limb("right_forearm")] == pytest.approx(expected)
    assert found.distance[0, limb("right_forearm")] < found.distance[0, limb("left_forearm")]
    assert np.isnan(circumstances_of(np.array([0]), points, (), 10.0).distance).all()


def test_speeds_are_those_of_far_ends_and_do_not_cross_gaps():
    frame = np.array([0, 1, 2, 3, 7, 8, 12])
    points = np.repeat(landmarks(BODY, t_pose(HIPS))[None], len(frame), axis=0)
    hand = LANDMARKS.index("left_hand")
    points[:, hand, 1] += 0.05 * frame  # half a metre a second at 10 Hz
    speed = circumstances_of(frame, points, (NORTH,), 10.0).speed
    np.testing.assert_allclose(speed[:-1, limb("left_forearm")], 0.5, atol=1e-9)
    assert np.isnan(speed[-1]).all()
    np.testing.assert_allclose(speed[:-1, limb("left_upper_arm")], 0.0, atol=1e-9)
    two = circumstances_of(frame[:2], points[:2], (NORTH,), 10.0).speed
    np.testing.assert_allclose(two[:, limb("left_forearm")], 0.5, atol=1e-9)
    points[1, hand] = np.nan
    unknown = circumstances_of(frame, points, (NORTH,), 10.0).speed[:, limb("left_forearm")]
    assert unknown[1] == pytest.approx(0.5)  # by the frames before and after
    assert np.isnan(unknown[0])


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


def test_views_are_counted_frame_by_frame_and_the_work_can_be_stopped():
    done = []
    poses = [t_pose(HIPS), None]
    views = views_that_see(BODY, poses, (NORTH, EAST), on_progress=done.append)
    assert views[0, limb("right_forearm")] == 2
    assert views[0, limb("left_upper_arm")] == 1
    assert np.isnan(views[1]).all()
    assert done == [1, 2]
    with pytest.raises(Cancelled):
        views_that_see(BODY, poses, (NORTH,), cancelled=lambda: True)
