"""The first pose."""

import numpy as np
import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.pose import t_pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.tracking.initialise.seeds import crown_over_hips, t_pose_in_cloud
from tests.tracking.scenes import surface_points

BODY = body_model(AVERAGE)


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


def test_the_crown_is_the_highest_place_of_the_head():
    a = AVERAGE
    expected = a.torso_length + a.shoulder_to_head + 0.135 + 0.055
    assert crown_over_hips(BODY) == pytest.approx(expected, abs=0.03)
