"""Ellipsoids of hands and elbows follow the tracker's covariance."""

import numpy as np
import pytest

from app.features.view.scene import SHOWN, ellipsoids_of
from app.session.runs import RunEntry
from stereotrack_core.body.angles import ALL_JOINTS, THESIS_JOINTS, pose_of_state, state_of_pose
from stereotrack_core.body.manifold import displaced
from stereotrack_core.body.model import body_model, landmarks
from stereotrack_core.body.pose import hanging_pose
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.frame import TrackedFrame

BODY = body_model(proportions_of(None))
POSE = displaced(
    hanging_pose(np.array([0.1, 0.2, 1.0])),
    np.random.default_rng(0).normal(0.0, 0.3, 6 + 2 * len(ALL_JOINTS)),
    ALL_JOINTS,
)
ENTRY = RunEntry("run", "accurate", None, BODY, range(1))


def tracked(joints, P, found=True):
    nothing = Cloud(0, np.empty((0, 3)), np.empty(0, int), np.empty((0, 2), int), (), {})
    x = state_of_pose(POSE, joints)
    pose = pose_of_state(x, joints) if joints == THESIS_JOINTS else POSE
    estimate = Estimate(found, "", pose, x, P, 0.0, 0.0, 1.0, np.zeros(6), None, {})
    return TrackedFrame(0, estimate, landmarks(BODY, pose), nothing, {})


@pytest.mark.parametrize("joints", [THESIS_JOINTS, ALL_JOINTS])
def test_they_agree_with_many_random_poses(joints):
    rng = np.random.default_rng(1)
    n = 6 + 2 * len(joints)
    root = rng.normal(0.0, 0.01, (n, n))
    P = root @ root.T
    frame = tracked(joints, P)
    errors = rng.multivariate_normal(np.zeros(n), P, 20_000)
    poses = (
        pose_of_state(frame.x + errors, joints)
        if joints == THESIS_JOINTS
        else displaced(POSE, errors, joints)
    )
    places = landmarks(BODY, poses)
    found = ellipsoids_of(ENTRY, frame)
    assert len(found) == len(SHOWN)
    for name, ellipsoid in zip(SHOWN, found, strict=True):
        at = LANDMARKS.index(name)
        np.testing.assert_allclose(ellipsoid.centre, frame.landmarks[at])
        expected = np.cov(places[:, at].T)
        np.testing.assert_allclose(ellipsoid.covariance, expected, atol=0.08 * expected.max())


def test_there_are_none_where_nothing_is_known():
    n = 6 + 2 * len(ALL_JOINTS)
    assert ellipsoids_of(ENTRY, tracked(ALL_JOINTS, np.full((n, n), np.nan))) == ()
    assert ellipsoids_of(ENTRY, tracked(ALL_JOINTS, np.eye(n), found=False)) == ()
