"""Limits of a body: as soft rows of the correction, and as the thesis jumps there."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.body.angles import ALL_JOINTS, THESIS_JOINTS, pose_of_state
from stereotrack_core.body.manifold import (
    ELBOW,
    KINDS,
    TORSO_ROW,
    columns_of,
    difference,
    displaced,
)
from stereotrack_core.body.model import body_model, landmarks
from stereotrack_core.body.pose import hanging_pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.filtering.linearisation import posterior
from stereotrack_core.geometry.rotation import angle_between, rotation_from_vector
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tracking.correction import gathered
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.residuals.limits import limit_rows
from stereotrack_core.tracking.thesis_collisions import collisions_avoided
from tests.oracle.limits import limits
from tests.tracking.scenes import POSES, numerical_information, pose_with_arms

BODY = body_model(AVERAGE)
PARAMETERS = TrackingParameters(clearance=0.045)
IN_BELLY = pose_with_arms([0.5, 0.1, -1], [-1, 0.1, 0.1], [-1, 0, 0], [-1, 0.1, 0])
FOLDED = pose_with_arms([1, 0, 0], [-1, 0.15, 0], [-1, 0, 0], [-1, 0.1, 0])


def _rows(pose, kind, joints=THESIS_JOINTS, parameters=PARAMETERS):
    found = limit_rows(BODY, pose, parameters, joints)
    return found[found["kind"] == kind]


def _corrected(pose, rounds=8):
    """The pose after corrections by its limits alone."""
    n = 6 + 2 * len(ALL_JOINTS)
    P0 = np.diag(np.r_[np.full(6, 1e-6), np.full(n - 6, 0.5)])
    prior = pose
    for _ in range(rounds):
        rows = limit_rows(BODY, pose, PARAMETERS, ALL_JOINTS)
        plain = limits(BODY, pose, PARAMETERS, ALL_JOINTS)
        assert [KINDS[kind] for kind in rows["kind"]] == [number.kind for number in plain]
        A, b = numerical_information(plain, BODY, pose, ALL_JOINTS)
        found = gathered((rows,), BODY.frames(pose), columns_of(ALL_JOINTS))
        np.testing.assert_allclose(found.A, A, atol=1e-5 * np.abs(found.A).max())
        np.testing.assert_allclose(found.b, b, atol=1e-4 * np.abs(found.b).max() + 1e-9)
        dx, _ = posterior(np.linalg.inv(P0), difference(prior, pose, ALL_JOINTS), found)
        pose = displaced(pose, np.clip(dx, -0.5, 0.5), ALL_JOINTS)
    return pose


def test_a_folded_elbow_is_asked_to_open():
    (row,) = _rows(FOLDED, ELBOW)
    assert row["part"] == 5
    before = FOLDED.rotations[5, :, 2]
    np.testing.assert_allclose(row["innovation"], np.radians(150.0) - np.arccos(before[2]))
    along = _corrected(FOLDED, 1).rotations[5, :, 2]
    assert np.degrees(np.arccos(before[2])) > 165
    assert 145 < np.degrees(np.arccos(along[2])) < 160


def test_an_arm_in_the_torso_is_pushed_out():
    rows = _rows(IN_BELLY, TORSO_ROW)
    assert set(rows["part"]) == {5}
    assert (rows["innovation"] > 0.0).all()
    after = _rows(_corrected(IN_BELLY, 1), TORSO_ROW)
    assert (after["innovation"] < 0.5 * rows["innovation"].max()).all()


THESIS_BODY = body_model(AVERAGE, preset("thesis").body)
SIDES = ("left", "right")


def _freed(pose):
    return collisions_avoided(THESIS_BODY, pose, 0.15, np.radians(30.0)).after


def _in_torso(pose):
    """Landmarks by name in the torso's frame."""
    local = (landmarks(THESIS_BODY, pose) - pose.position) @ pose.torso
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


def _outside(point, least):
    """A point of the torso's frame, moved out of the torso's ellipse by the least distance."""
    clear = _clearance(point)
    if clear >= least:
        return point
    out = np.append(point[:2] / np.hypot(*point[:2]), 0.0)
    return point + (least - clear) * out


@pytest.mark.parametrize("seed", range(25))
def test_arms_are_aimed_at_where_elbow_and_hand_are_free(seed):
    rng = np.random.default_rng(seed)
    hanging = CLOSE[sorted(CLOSE)[seed % 4]]
    arms = np.isin(np.arange(12), (2, 3, 4, 5))[:, None]
    turns = rotation_from_vector(0.5 * rng.normal(size=(12, 3)) * arms)
    pose = replace(hanging, rotations=hanging.rotations @ turns)
    jump = collisions_avoided(THESIS_BODY, pose, 0.15, np.radians(30.0))
    frames, after = THESIS_BODY.frames(pose), THESIS_BODY.frames(jump.after)
    lengths, torso = THESIS_BODY.skeleton.lengths, pose.torso
    for side, found in enumerate(jump.arms):
        upper, fore = 2 + side, 4 + side
        ends = frames.origins[fore] + np.outer([0.0, lengths[fore]], frames.rotations[fore, :, 2])
        elbow, hand = (ends - pose.position) @ torso
        free_elbow, free_hand = (_outside(one, 0.15) for one in (elbow, hand))
        assert found.elbow_missing == pytest.approx(np.linalg.norm(free_elbow - elbow), abs=1e-9)
        assert found.hand_missing == pytest.approx(np.linalg.norm(free_hand - hand), abs=1e-9)
        bend = angle_between(frames.rotations[upper, :, 2], frames.rotations[fore, :, 2])
        assert found.bend_missing == pytest.approx(max(0.0, bend - np.radians(150.0)), abs=1e-7)
        shoulder = THESIS_BODY.skeleton.joints[upper]
        along = (free_elbow - shoulder) / np.linalg.norm(free_elbow - shoulder)
        assert after.rotations[upper, :, 2] @ torso == pytest.approx(along)
        target = free_hand - shoulder - lengths[upper] * along
        if found.elbow_missing == found.hand_missing == 0.0:
            target = hand - elbow
        target /= np.linalg.norm(target)
        if angle_between(along, target) > np.radians(150.0):
            across = target - (target @ along) * along
            across /= np.linalg.norm(across)
            target = np.cos(np.radians(150.0)) * along + 0.5 * across
        assert after.rotations[fore, :, 2] @ torso == pytest.approx(target, abs=1e-7)
