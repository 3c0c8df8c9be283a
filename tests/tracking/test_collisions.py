"""Arms off the torso and elbows unfolded, as the thesis jumps there."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.body.angles import THESIS_JOINTS, pose_of_state
from stereotrack_core.body.model import body_model, landmarks
from stereotrack_core.body.pose import hanging_pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.geometry.rotation import angle_between
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.thesis_collisions import collisions_avoided
from tests.tracking.scenes import POSES, pose_with_arms

BODY = body_model(AVERAGE, preset("thesis").body)
SIDES = ("left", "right")


def _freed(pose):
    return collisions_avoided(BODY, pose, 0.15, np.radians(30.0)).after


def _in_torso(pose):
    """Landmarks by name in the torso's frame."""
    local = (landmarks(BODY, pose) - pose.position) @ pose.torso
    return dict(zip(LANDMARKS, local, strict=True))


def _edge(azimuth, z):
    """Distance of the torso's cross-section from its axis: an ellipse in polar form."""
    a = 0.165 + (0.175 - 0.165) * (z + 0.05) / (AVERAGE.torso_length + 0.05)
    b = preset("thesis").body.torso_flatness * a
    return a * b / np.hypot(b * np.cos(azimuth), a * np.sin(azimuth))


def _clearance(point):
    """Distance from the torso, radially; infinite above the shoulders and below the hips."""
    if not 0.0 <= point[2] <= AVERAGE.torso_length:
        return np.inf
    return np.hypot(*point[:2]) - _edge(np.arctan2(point[1], point[0]), point[2])


def _bend(points, side):
    upper = points[f"{side}_elbow"] - points[f"{side}_shoulder"]
    fore = points[f"{side}_hand"] - points[f"{side}_elbow"]
    return np.pi - angle_between(upper, fore)


def _is_free(points):
    ends = [points[f"{side}_{end}"] for side in SIDES for end in ("elbow", "hand")]
    return min(map(_clearance, ends)) >= 0.15 and min(
        _bend(points, side) for side in SIDES
    ) >= np.radians(30.0)


CLOSE = {
    "hanging": hanging_pose(np.zeros(3)),
    "hands on the belly": pose_with_arms(
        [0.5, 0.1, -1], [-1, 0.6, 0], [-0.5, 0.1, -1], [1, 0.6, 0]
    ),
    "hands on the back": pose_with_arms(
        [0.6, -0.5, -1], [-1, -0.3, 0], [-0.6, -0.5, -1], [1, -0.3, 0]
    ),
    "an arm in the torso": pose_with_arms(
        [-0.4, 0.2, -1], [0.1, 0.3, -1], [-1, 0, 0], [-1, 0.1, 0]
    ),
}


@pytest.mark.parametrize("name", POSES)
def test_free_poses_stay_as_they_are(name):
    assert _is_free(_in_torso(POSES[name]))
    assert _freed(POSES[name]) is POSES[name]


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_any_pose_is_left_alone_where_it_is_free_and_ends_with_open_elbows(seed):
    rng = np.random.default_rng(seed)
    x = np.concatenate([rng.normal(size=6), rng.uniform(-np.pi, np.pi, 8)])
    pose = pose_of_state(x, THESIS_JOINTS)
    free = _freed(pose)
    points = _in_torso(free)
    assert min(_bend(points, side) for side in SIDES) > np.radians(30.0) - 1e-9
    np.testing.assert_array_equal(free.torso, pose.torso)
    np.testing.assert_array_equal(free.position, pose.position)
    if _is_free(_in_torso(pose)):
        np.testing.assert_array_equal(free.rotations, pose.rotations)


@pytest.mark.parametrize("name", CLOSE)
def test_elbows_and_hands_come_off_the_torso(name):
    """The lengths of the arms decide how near to the least distance they can come."""
    before, after = _in_torso(CLOSE[name]), _in_torso(_freed(CLOSE[name]))
    moved = 0
    for side in SIDES:
        for end in ("elbow", "hand"):
            was, found = _clearance(before[f"{side}_{end}"]), _clearance(after[f"{side}_{end}"])
            if was < 0.15:
                assert found > was + 0.01
                moved += 1
            assert found > 0.1
    assert moved >= 1


@pytest.mark.parametrize("name", CLOSE)
@pytest.mark.parametrize("side", SIDES)
def test_the_elbow_is_turned_to_the_nearest_free_place_outwards(name, side):
    before, after = _in_torso(CLOSE[name]), _in_torso(_freed(CLOSE[name]))
    elbow = before[f"{side}_elbow"]
    target = elbow.copy()
    if _clearance(elbow) < 0.15:
        azimuth = np.arctan2(elbow[1], elbow[0])
        reach = _edge(azimuth, elbow[2]) + 0.15
        target[:2] = reach * np.cos(azimuth), reach * np.sin(azimuth)
    shoulder = before[f"{side}_shoulder"]
    assert angle_between(after[f"{side}_elbow"] - shoulder, target - shoulder) < 1e-3


def test_the_hand_returns_to_where_it_was_when_only_the_elbow_was_too_near():
    pose = pose_with_arms([0.25, 0, -1], [1, 0.8, 0.2], [-1, 0, 0], [-1, 0.1, 0])
    before, after = _in_torso(pose), _in_torso(_freed(pose))
    assert _clearance(before["right_elbow"]) < 0.15 < _clearance(before["right_hand"])
    aimed = before["right_hand"] - after["right_elbow"]
    assert angle_between(after["right_hand"] - after["right_elbow"], aimed) < 1e-7


def test_an_elbow_that_is_folded_too_far_opens_in_its_plane():
    pose = pose_with_arms([1, 0, 0], [-1, 0.2, 0.1], [-1, 0, 0], [-1, 0.1, 0])
    before, after = _in_torso(pose), _in_torso(_freed(pose))
    assert _bend(before, "right") < np.radians(20.0)
    assert _bend(after, "right") == pytest.approx(np.radians(30.0))
    upper = before["right_elbow"] - before["right_shoulder"]
    across = np.cross(upper, before["right_hand"] - before["right_elbow"])
    fore = after["right_hand"] - after["right_elbow"]
    assert fore @ across == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("direction", [[0, 0, 1], [1e-13, 0, 1]])
def test_an_elbow_folded_completely_opens_too(direction):
    pose = pose_with_arms([0, 0, -1], direction, [-1, 0, 0], [-1, 0.1, 0])
    after = _in_torso(_freed(pose))
    assert _bend(after, "right") > np.radians(30.0) - 1e-6


@pytest.mark.parametrize("name", [*POSES, "an arm in the torso"])
def test_the_other_arm_is_not_touched(name):
    pose = {**POSES, **CLOSE}[name]
    free = _freed(pose)
    np.testing.assert_array_equal(free.rotations[[2, 4]], pose.rotations[[2, 4]])
