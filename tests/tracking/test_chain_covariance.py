"""Covariances that are stored with a state belong to the axes that the state gives again."""

from __future__ import annotations

import numpy as np
import pytest

from stereotrack_core.body.angles import (
    ALL_JOINTS,
    THESIS_JOINTS,
    pose_of_state,
    state_names,
    state_of_pose,
)
from stereotrack_core.body.manifold import displaced
from stereotrack_core.body.model import body_model, landmarks
from stereotrack_core.body.pose import t_pose
from stereotrack_core.body.proportions import proportions_of
from stereotrack_core.tracking.frame import in_chain_axes, joints_named

BODY = body_model(proportions_of(None))


def turned_pose(rng):
    """A pose whose limbs have been turned about their own axes on their way."""
    pose = t_pose(np.zeros(3))
    for _ in range(30):
        pose = displaced(pose, 0.3 * rng.normal(size=6 + 2 * len(ALL_JOINTS)), ALL_JOINTS)
    return pose


def spread(pose, P):
    """Covariance (27, 27) of all landmarks to first order."""
    step = 1e-5
    steps = step * np.eye(len(P))
    ahead, behind = (landmarks(BODY, displaced(pose, s * steps, ALL_JOINTS)) for s in (1, -1))
    J = ((ahead - behind) / (2 * step)).reshape(len(P), -1).T
    return J @ P @ J.T


@pytest.mark.parametrize("seed", range(4))
def test_landmarks_are_as_uncertain_about_the_states_pose_as_about_the_trackers(seed):
    rng = np.random.default_rng(seed)
    pose = turned_pose(rng)
    x = state_of_pose(pose, ALL_JOINTS)
    root = rng.normal(size=(len(x), len(x)))
    P = 1e-3 * root @ root.T
    stored, again = in_chain_axes(pose, x, P, ALL_JOINTS), pose_of_state(x, ALL_JOINTS)
    expected = spread(pose, P)
    np.testing.assert_allclose(spread(again, stored), expected, atol=1e-8)
    assert np.abs(spread(again, P) - expected).max() > 1e-3  # it does make a difference


def test_a_state_of_the_thesis_and_an_unknown_covariance_stay():
    pose = t_pose(np.zeros(3))
    P = np.diag(np.arange(1.0, 15.0))
    x = state_of_pose(pose, THESIS_JOINTS)
    assert in_chain_axes(pose, x, P, THESIS_JOINTS) is P
    unknown = np.full((24, 24), np.nan)
    assert np.isnan(in_chain_axes(pose, np.zeros(24), unknown, ALL_JOINTS)).all()


def test_joints_are_known_by_the_names_of_the_state():
    for joints in (THESIS_JOINTS, ALL_JOINTS):
        assert joints_named(state_names(joints)) == joints
    assert joints_named(("a", "b")) is None
    assert joints_named((*state_names(THESIS_JOINTS), "tail_alpha", "tail_beta")) is None
