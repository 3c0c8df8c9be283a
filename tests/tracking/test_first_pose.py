"""The first pose of a track, found without help."""

import numpy as np
import pytest

from stereotrack_core.body.manifold import difference
from stereotrack_core.geometry.rotation import angle_between
from stereotrack_core.tracking.initialise.first_pose import facing_right, first_pose_in
from stereotrack_core.tracking.initialise.seeds import t_pose_in_cloud
from stereotrack_core.tracking.initialise.trunk import turned_round
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.state import Setup
from stereotrack_core.tracking.tracker import initialiser as looking
from tests.tracking.scenes import CAMERAS, POSES, axis_off, cloud_of, surface_points, turned


@pytest.fixture
def initialiser(make_tracker):
    body = make_tracker("manifold").setup.body
    return looking(Setup(body, preset("fast").tracking, CAMERAS, 10.0, 0))


def test_the_first_pose_is_that_of_the_first_cloud(initialiser, rng):
    poses = [turned(POSES["reaching"], 30.0, (0.0, 0.03 * k, 0.0)) for k in range(4)]
    clouds = [
        cloud_of(surface_points(initialiser.setup.body, pose, 2000, rng, 0.005), k)
        for k, pose in enumerate(poses)
    ]
    shares = []
    found = first_pose_in(initialiser, clouds, lambda done, count: shares.append(done / count))
    assert shares == sorted(shares)
    assert shares[0] == 0.0
    assert 0.5 < shares[-1] < 1.0
    assert found is not None
    assert np.abs(difference(found, poses[0], initialiser.setup.joints)[:3]).max() < 0.03
    assert first_pose_in(initialiser, [cloud_of(np.empty((0, 3)))]) is None


def _clouds(initialiser, pose, rng, count=4):
    return [
        cloud_of(surface_points(initialiser.setup.body, pose, 2000, rng, 0.005), k)
        for k in range(count)
    ]


def test_the_usual_first_pose_is_taken_where_it_explains_the_clouds(initialiser, rng):
    clouds = _clouds(initialiser, POSES["t"], rng)
    found, usual = (
        first_pose_in(initialiser, clouds),
        t_pose_in_cloud(initialiser.setup.body, clouds[0].points),
    )
    assert found is not None
    np.testing.assert_array_equal(found.rotations, usual.rotations)
    np.testing.assert_array_equal(found.position, usual.position)


@pytest.mark.parametrize(
    ("name", "heading"), [("reaching", 90.0), ("reaching", 180.0), ("t", 90.0)]
)
def test_another_first_pose_is_not_taken_for_the_usual(initialiser, rng, name, heading):
    true = turned(POSES[name], heading)
    found = first_pose_in(initialiser, _clouds(initialiser, true, rng))
    assert found is not None
    assert axis_off(found, true) < 12.0
    if name == "reaching":
        assert angle_between(found.torso[:, 0], true.torso[:, 0]) < np.radians(30.0)


def test_the_usual_first_pose_is_that_of_the_first_cloud_with_somebody(initialiser, rng):
    clouds = [cloud_of(np.empty((0, 3))), *_clouds(initialiser, POSES["t"], rng)]
    found, usual = (
        first_pose_in(initialiser, clouds),
        t_pose_in_cloud(initialiser.setup.body, clouds[1].points),
    )
    assert found is not None
    np.testing.assert_array_equal(found.position, usual.position)


@pytest.mark.parametrize("heading", [0.0, 130.0])
def test_a_body_taken_from_the_wrong_side_is_turned(initialiser, rng, heading):
    true = turned(POSES["reaching"], heading)
    clouds = _clouds(initialiser, true, rng, 2)
    for start in (true, turned_round(true)):
        found = facing_right(initialiser, start, clouds)
        assert angle_between(found.torso[:, 1], true.torso[:, 1]) < np.radians(30.0)
