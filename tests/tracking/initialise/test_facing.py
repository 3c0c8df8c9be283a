"""Half a turn with left and right exchanged looks alike; knees and trunks tell the difference."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.body.model import body_model, landmarks
from stereotrack_core.body.pose import Pose, hanging_pose, rotation_towards
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.skeleton import LEFT_SHANK, LEFT_THIGH, RIGHT_SHANK, RIGHT_THIGH, TORSO
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.tracking.initialise import trunk
from stereotrack_core.tracking.initialise.finder import TURN_GAIN, PoseFinder
from stereotrack_core.tracking.initialise.trunk import facing_cost, turned_round
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.state import Setup
from tests.tracking.keypoints.test_reprojection import seen
from tests.tracking.scenes import CAMERAS, POSES, cloud_of, surface_points

BODY = body_model(AVERAGE)
NOBODY = np.empty((0, 3))
STANDING = hanging_pose(np.array([0.0, 0.0, 0.9]))


def _lean(degrees: float) -> Pose:
    """Upright legs, the trunk bent to the front by so many degrees."""
    torso = rotation_from_vector(np.array([-np.radians(degrees), 0.0, 0.0]))
    rotations = hanging_pose(np.zeros(3), torso).rotations.copy()
    for part in (LEFT_THIGH, RIGHT_THIGH):
        down = rotations[TORSO].T @ np.array([0.0, 0.0, -1.0])
        rotations[part] = rotation_towards(rotations[part], down)
    return Pose(np.array([0.0, 0.0, 0.9]), rotations)


def _knees(degrees: float) -> Pose:
    """Standing with both shanks swung back by so many degrees."""
    rotations = STANDING.rotations.copy()
    angle = np.radians(degrees)
    for shank, thigh in ((LEFT_SHANK, LEFT_THIGH), (RIGHT_SHANK, RIGHT_THIGH)):
        back = np.array([0.0, -np.sin(angle), -np.cos(angle)])
        rotations[shank] = rotation_towards(rotations[shank], rotations[thigh].T @ back)
    return Pose(STANDING.position, rotations)


@pytest.mark.parametrize("name", POSES)
def test_landmarks_change_sides_and_stay_where_they_are(name):
    pose = POSES[name]
    before, after = landmarks(BODY, pose), landmarks(BODY, turned_round(pose))
    np.testing.assert_allclose(after, before[[1, 0, 3, 2, 5, 4, 6, 8, 7]], atol=1e-12)


@pytest.mark.parametrize("pose", [_knees(30.0), _lean(40.0)], ids=["knees", "lean"])
def test_bodies_bend_to_the_front_and_knees_to_the_back(pose):
    assert facing_cost(BODY, pose, NOBODY, CAMERAS) == pytest.approx(0.0, abs=1e-9)
    assert facing_cost(BODY, turned_round(pose), NOBODY, CAMERAS) > 5.0


@pytest.mark.parametrize("name", POSES)
def test_a_pose_the_other_way_round_is_turned(name, rng):
    setup = Setup(BODY, preset("accurate").tracking, CAMERAS, 10.0, 0)
    finder, pose = PoseFinder(setup), POSES[name]
    cloud = cloud_of(surface_points(BODY, pose, 600, rng))
    with_keypoints = replace(cloud, keypoints=seen(pose))
    for other, sign in ((turned_round(pose), 1.0), (pose, -1.0)):
        alone = finder.gain_of_turning(other, cloud)
        gain = finder.gain_of_turning(other, with_keypoints)
        assert sign * (gain - alone) > 2.0 * TURN_GAIN


@pytest.mark.parametrize(
    ("column", "row", "z", "counted"),
    [
        pytest.param(2, 1, 1.5, 0, id="looked through"),
        pytest.param(2, 1, 1.93, 1, id="supported"),
        pytest.param(2, 1, 2.07, 1, id="supported from in front"),
        pytest.param(2, 1, 1.85, None, id="neither"),
        pytest.param(2, 1, 2.5, 2, id="hidden"),
        pytest.param(3, 1, 2.0, 0, id="beside the silhouette"),
        pytest.param(4, 1, 2.0, 3, id="in the silhouette"),
        pytest.param(2, 1, -2.0, None, id="behind the camera"),
        *[pytest.param(*at, 1.5, None, id=f"outside {at}") for at in ((-1, 1), (5, 1), (2, -1))],
        *[pytest.param(*at, 1.5, 0, id=f"at the border {at}") for at in ((0, 1), (2, 0), (2, 2))],
        pytest.param(2, 3, 1.5, None, id="below"),
    ],
)
def test_how_a_view_judges_a_place(column, row, z, counted):
    image, silhouette = np.full((3, 5), 2.0), np.zeros((3, 5), dtype=np.bool_)
    image[1, 3:], silhouette[1, 4] = np.nan, True
    place, seen = np.array([[(column - 2) * z / 9, (row - 1) * z / 9, z]]), np.zeros((1, 4), int)
    trunk._count_sight(
        place, image, silhouette, np.array([9.0, 2, 1]), np.array([0.05, 0.02]), seen
    )
    assert seen[0].tolist() == [int(k == counted) for k in range(4)]
