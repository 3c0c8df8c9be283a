"""Half a turn with left and right exchanged looks alike; knees and trunks tell the difference."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.body.model import body_model, landmarks
from stereotrack_core.body.pose import Pose, hanging_pose, rotation_towards
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.skeleton import LEFT_SHANK, LEFT_THIGH, RIGHT_SHANK, RIGHT_THIGH, TORSO
from stereotrack_core.geometry.rotation import rotation_from_vector
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


def test_toes_tell_the_front():
    frames = BODY.frames(STANDING)
    rng = np.random.default_rng(0)
    ankles = [
        frames.origins[shank] + BODY.skeleton.lengths[shank] * frames.rotations[shank, :, 2]
        for shank in (LEFT_SHANK, RIGHT_SHANK)
    ]
    toes = [ankle + [0.0, 0.10, -0.03] + rng.normal(0, 0.02, (40, 3)) for ankle in ankles]
    points = np.concatenate(toes)
    assert facing_cost(BODY, STANDING, points, CAMERAS) < 1.0
    assert facing_cost(BODY, turned_round(STANDING), points, CAMERAS) > 5.0


def test_who_is_seen_by_one_camera_rather_faces_it():
    assert facing_cost(BODY, STANDING, NOBODY, CAMERAS[:1]) < 0.1
    assert facing_cost(BODY, STANDING, NOBODY, CAMERAS[2:3]) > 10.0


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
