"""Limits as soft rows of the correction."""

import numpy as np
import pytest

from stereotrack_core.body.angles import ALL_JOINTS, THESIS_JOINTS, pose_of_state, state_of_pose
from stereotrack_core.body.manifold import columns_of, difference, displaced
from stereotrack_core.body.model import body_model
from stereotrack_core.body.pose import hanging_pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.filtering.linearisation import posterior
from stereotrack_core.tracking.correction import gathered
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.residuals.limits import (
    ClearanceResidual,
    DirectionResidual,
    limit_residuals,
)
from stereotrack_core.tracking.state import GIRDLE_REST
from tests.tracking.scenes import POSES, numerical_information, pose_with_arms

BODY = body_model(AVERAGE)
PARAMETERS = TrackingParameters(clearance=0.045)
IN_BELLY = pose_with_arms([0.5, 0.1, -1], [-1, 0.1, 0.1], [-1, 0, 0], [-1, 0.1, 0])
FOLDED = pose_with_arms([1, 0, 0], [-1, 0.15, 0], [-1, 0, 0], [-1, 0.1, 0])


def _rows(pose, kind, joints=THESIS_JOINTS, parameters=PARAMETERS):
    found = limit_residuals(BODY, pose, parameters, joints)
    return [row for row in found if isinstance(row, kind)]


def _corrected(pose, rounds=8):
    """The pose after corrections by its limits alone."""
    n = 6 + 2 * len(ALL_JOINTS)
    P0 = np.diag(np.r_[np.full(6, 1e-6), np.full(n - 6, 0.5)])
    prior = pose
    for _ in range(rounds):
        rows = limit_residuals(BODY, pose, PARAMETERS, ALL_JOINTS)
        A, b = numerical_information(rows, BODY, pose, ALL_JOINTS)
        found = gathered(rows, BODY, pose, columns_of(ALL_JOINTS))
        np.testing.assert_allclose(found.A, A, atol=1e-5 * np.abs(found.A).max())
        np.testing.assert_allclose(found.b, b, atol=1e-4 * np.abs(found.b).max() + 1e-9)
        dx, _ = posterior(np.linalg.inv(P0), difference(prior, pose, ALL_JOINTS), found)
        pose = displaced(pose, np.clip(dx, -0.5, 0.5), ALL_JOINTS)
    return pose


@pytest.mark.parametrize("name", POSES)
def test_free_poses_have_no_rows(name):
    assert limit_residuals(BODY, POSES[name], PARAMETERS, THESIS_JOINTS) == ()


def test_head_and_legs_rest(rng):
    row, _ = _rows(POSES["t"], DirectionResidual, ALL_JOINTS)
    assert row.part.tolist() == [1, 1, 6, 6, 8, 8, 7, 7, 9, 9]
    frames = BODY.frames(POSES["t"])
    one = type(frames)(frames.rotations[None], frames.origins[None])
    np.testing.assert_allclose(row.predicted(one), 0.0, atol=1e-12)
    moved = displaced(POSES["t"], 0.3 * rng.normal(size=(1, 28)), ALL_JOINTS)
    assert abs(row.predicted(BODY.frames(moved))).max() > 0.05


def _girdle_sigmas(alpha, beta):
    """Standard deviations (4,) in degrees of the rows for clavicles turned so, left and right."""
    x = state_of_pose(POSES["t"], ALL_JOINTS)
    x[-4:] = np.radians([alpha, beta] * 2)
    row = _rows(pose_of_state(x, ALL_JOINTS), DirectionResidual, ALL_JOINTS)[-1]
    assert row.part.tolist() == [10, 10, 11, 11]
    return np.degrees(np.sqrt(row.variance))


def test_shoulders_are_held_the_less_the_farther_they_are_lifted_or_pushed_forward():
    rest = np.degrees(GIRDLE_REST)
    np.testing.assert_allclose(_girdle_sigmas(0.0, 0.0), rest)
    lifted, forward = _girdle_sigmas(0.0, -20.0), _girdle_sigmas(-15.0, 0.0)
    np.testing.assert_allclose(lifted[[0, 2]], np.hypot(rest, 20.0), rtol=0.03)
    np.testing.assert_allclose(lifted[[1, 3]], rest)
    np.testing.assert_allclose(forward[[1, 3]], np.hypot(rest, 15.0), rtol=0.03)
    np.testing.assert_allclose(_girdle_sigmas(15.0, 0.0), forward)
    np.testing.assert_allclose(_girdle_sigmas(0.0, 20.0), rest)  # nobody lowers them far


def test_lifted_shoulders_are_drawn_towards_their_rest():
    x = state_of_pose(POSES["t"], ALL_JOINTS)
    x[-4:] = np.radians([0.0, -20.0] * 2)
    pose = pose_of_state(x, ALL_JOINTS)
    found = gathered(_rows(pose, DirectionResidual, ALL_JOINTS), BODY, pose, columns_of(ALL_JOINTS))
    dx, _ = posterior(np.eye(28) / np.radians(5.0) ** 2, np.zeros(28), found)
    after = state_of_pose(displaced(pose, dx, ALL_JOINTS), ALL_JOINTS)
    assert np.all(np.degrees(after[[25, 27]]) > -19.5)
    assert np.all(np.degrees(after[[25, 27]]) < 0.0)


def test_a_folded_elbow_is_asked_to_open():
    (row,) = _rows(FOLDED, DirectionResidual)
    assert row.part.tolist() == [5]
    before = FOLDED.rotations[5, :, 2]
    np.testing.assert_allclose(row.measured, np.radians(150.0) - np.arccos(before[2]))
    along = _corrected(FOLDED, 1).rotations[5, :, 2]
    assert np.degrees(np.arccos(before[2])) > 165
    assert 145 < np.degrees(np.arccos(along[2])) < 160


def test_an_arm_in_the_torso_is_pushed_out():
    (row,) = _rows(IN_BELLY, ClearanceResidual)
    assert set(row.part) == {5}
    frames = BODY.frames(IN_BELLY)
    here = row.predicted(type(frames)(frames.rotations[None], frames.origins[None]))[0]
    assert (row.measured > here).all()
    after = _rows(_corrected(IN_BELLY, 1), ClearanceResidual)
    deepest = (row.measured - here).max()
    for left in after:
        frames = BODY.frames(_corrected(IN_BELLY, 1))
        there = left.predicted(type(frames)(frames.rotations[None], frames.origins[None]))[0]
        assert (left.measured - there).max() < 0.5 * deepest


def test_no_clearance_asks_for_nothing():
    parameters = TrackingParameters(clearance=0.0)
    assert not _rows(IN_BELLY, ClearanceResidual, parameters=parameters)
    assert not _rows(hanging_pose(np.zeros(3)), DirectionResidual)
