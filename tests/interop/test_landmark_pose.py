"""Poses from landmarks: the body in that pose has its landmarks there."""

import numpy as np
import pytest

from stereotrack_core.body.landmark_pose import pose_of_landmarks
from stereotrack_core.body.model import body_model, landmarks
from stereotrack_core.body.pose import t_pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.evaluation.summary import errors_against
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory


@pytest.mark.parametrize("seed", range(2))
def test_limbs_point_where_the_landmarks_say(body_trajectory, seed):
    trajectory = body_trajectory(np.random.default_rng(seed), range(5))
    body = body_model(AVERAGE)
    found = [landmarks(body, pose_of_landmarks(points)) for points in trajectory.points]
    errors = errors_against(LandmarkTrajectory(trajectory.frame, np.stack(found)), trajectory)
    np.testing.assert_allclose(errors.torso_position, 0.0, atol=1e-9)
    for name in ("torso_long", "torso_cross", "upper_arm", "forearm"):
        np.testing.assert_allclose(getattr(errors, name), 0.0, atol=1e-7)


def test_t_pose_comes_back():
    body = body_model(AVERAGE)
    wanted = t_pose(np.array([0.3, -0.2, 0.95]))
    found = pose_of_landmarks(landmarks(body, wanted))
    np.testing.assert_allclose(landmarks(body, found), landmarks(body, wanted), atol=1e-12)
    np.testing.assert_allclose(found.rotations[:6], wanted.rotations[:6], atol=1e-12)


def test_unknown_landmarks(body_trajectory, random):
    points = body_trajectory(random, [0]).points[0]
    points[LANDMARKS.index("head")] = np.nan
    assert np.isfinite(pose_of_landmarks(points).rotations).all()
    points[LANDMARKS.index("left_hand")] = np.nan
    with pytest.raises(ValueError, match="landmarks"):
        pose_of_landmarks(points)
