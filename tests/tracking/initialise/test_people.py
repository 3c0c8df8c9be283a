"""Groups of points that stand apart, and which of them are the body's own."""

import numpy as np
import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.pose import t_pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.tracking.initialise.people import own_points, people_in, trunk_support
from stereotrack_core.tracking.initialise.seeds import t_pose_in_cloud
from tests.tracking.scenes import CAMERAS, POSES, surface_points

BODY = body_model(AVERAGE)
POSE = POSES["t"]


def _body(shift, count, rng):
    return surface_points(BODY, POSE, count, rng) + shift


def test_two_people_are_two_groups_and_strays_are_none(rng):
    near, far = _body([0, 0, 0], 2000, rng), _body([0, 1.5, 0], 900, rng)
    stray = np.array([[1.7, -1.7, 0.3]])
    groups = people_in(np.concatenate([far, near, stray]), 150)
    assert [int(members.sum()) > 850 for members in groups] == [True, True]
    assert groups[0][900:-1].mean() > 0.98
    assert groups[1][:900].mean() > 0.98
    assert not any(members[-1] for members in groups)


def test_the_own_points_are_kept_and_those_of_somebody_else_are_not(rng):
    own, other = _body([0, 0, 0], 2000, rng), _body([0.1, 1.0, 0], 2000, rng)
    kept = own_points(np.concatenate([own, other]), BODY, POSE)
    assert kept[:2000].all()
    assert kept[2000:].mean() < 0.05


def test_a_small_group_in_reach_is_kept_for_it_may_be_a_hand(rng):
    own = _body([0, 0, 0], 2000, rng)
    hand = np.array([0.2, 0.8, 1.3]) + rng.normal(0, 0.03, (60, 3))
    assert own_points(np.concatenate([own, hand]), BODY, POSE)[2000:].all()


def test_support_falls_with_what_is_cut_away(rng):
    points = surface_points(BODY, POSE, 4000, rng)
    whole = trunk_support(BODY, POSE, points, CAMERAS)
    half = trunk_support(BODY, POSE, points[points[:, 0] < POSE.position[0]], CAMERAS)
    assert whole > 0.9
    assert 0.3 < half < 0.7
    assert trunk_support(BODY, POSE, np.empty((0, 3)), CAMERAS) == 0.0


def test_one_camera_expects_its_own_side_only(rng):
    points = surface_points(BODY, POSE, 4000, rng)
    camera = np.array([[0.0, 3.0, 1.5]])
    front = points[points[:, 1] > POSE.position[1] + 0.02]
    back = points[points[:, 1] < POSE.position[1] - 0.02]
    assert trunk_support(BODY, POSE, front, camera) > 0.8
    assert trunk_support(BODY, POSE, back, camera) < 0.3


@pytest.mark.parametrize("place", [(0.0, 0.0, 0.95), (0.7, -0.4, 1.1)])
def test_a_t_pose_is_put_where_the_cloud_is(rng, place):
    true = t_pose(np.array(place))
    strays = rng.uniform(-1.5, 1.5, (40, 3)) * [1, 1, 0.2] + [0, 0, 2.1]
    far = np.linalg.norm(strays[:, :2] - true.position[:2], axis=1) > 0.4
    points = np.concatenate([surface_points(BODY, true, 3000, rng, 0.005), strays[far]])
    found = t_pose_in_cloud(BODY, points)
    np.testing.assert_allclose(found.position[:2], true.position[:2], atol=0.03)
    assert abs(found.position[2] - true.position[2]) < 0.15  # the points leave out the crown
    np.testing.assert_array_equal(found.rotations, true.rotations)
