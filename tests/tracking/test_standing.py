"""What standing tells: how long legs are, and how upright a trunk is held."""

import dataclasses

import numpy as np
import pytest

from stereotrack_core.body.angles import ALL_JOINTS, THESIS_JOINTS
from stereotrack_core.body.manifold import displaced
from stereotrack_core.body.model import body_model
from stereotrack_core.body.parameters import BodyShape
from stereotrack_core.body.pose import PartFrames, t_pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.skeleton import HEAD, SHANKS, THIGHS
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.residuals.standing import soles, upright
from stereotrack_core.tracking.shape_fit import SeenPose, fitted_surface
from tests.tracking.scenes import disturbed, pose_with_arms, surface_points

STANDING = pose_with_arms([1, 0, -1], [1, 0, -1], [-1, 0, -1], [-1, 0, -1], place=(0.0, 0.0, 1.0))
BODY = body_model(AVERAGE)


def with_legs(factor):
    return body_model(AVERAGE, BodyShape().replaced(leg_length_factor=factor))


def seated():
    """Standing, with both thighs lifted by 60 degrees and the shanks hanging."""
    rotations = STANDING.rotations.copy()
    c, s = np.cos(np.radians(60.0)), np.sin(np.radians(60.0))
    for thigh, shank in zip(THIGHS, SHANKS, strict=True):
        bend = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
        rotations[thigh], rotations[shank] = rotations[thigh] @ bend, rotations[shank] @ bend.T
    return dataclasses.replace(STANDING, rotations=rotations)


@pytest.mark.parametrize("factor", [0.9, 1.15])
def test_the_fit_finds_how_long_the_legs_are(factor, rng):
    true = with_legs(factor)
    seen = [
        SeenPose(
            surface_points(true, STANDING, 900, rng, noise=0.005),
            disturbed(STANDING, ALL_JOINTS, rng, 0.01, 1.0, 2.0),
        )
        for _ in range(3)
    ]
    found, _ = fitted_surface(BODY, seen, TrackingParameters(), ALL_JOINTS)
    assert found.shape.leg_length_factor == pytest.approx(factor, abs=0.04)


def test_bent_or_cut_legs_do_not_tell_their_length(rng):
    points = surface_points(BODY, seated(), 2000, rng)
    assert not len(soles(points, BODY, seated(), 3).part)
    points = surface_points(BODY, STANDING, 2000, rng)
    cut = points[points[:, 2] > BODY.frames(STANDING).origins[SHANKS[0], 2] - 0.25]
    assert not len(soles(cut, BODY, STANDING, 3).part)


JOINTS = (*THESIS_JOINTS, HEAD)


def turned(rotation_vector):
    """A T pose with the whole body turned, world."""
    dx = np.zeros(6 + 2 * len(JOINTS))
    dx[3:6] = rotation_vector
    return displaced(t_pose(np.zeros(3)), dx, JOINTS)


def error(pose):
    (row,) = upright(pose, 4)
    frames = BODY.frames(pose)
    stacked = PartFrames(frames.rotations[None], frames.origins[None])
    return row.measured - row.predicted(stacked)[0]


@pytest.mark.parametrize("heading", [0.0, 1.0, -2.5, np.pi])
def test_a_lean_is_the_same_whichever_way_somebody_faces(heading):
    assert np.allclose(error(turned([0.0, 0.0, heading])), [0.0, np.sin(np.radians(2.0))])


def test_a_lean_backwards_is_asked_to_come_forward():
    # Turning about the person's right lifts the front: the trunk leans back.
    back = error(turned([np.radians(3.0), 0.0, 0.0]))
    assert back[1] == pytest.approx(np.sin(np.radians(5.0)), abs=1e-3)
    assert abs(back[0]) < 1e-9


@pytest.mark.parametrize(
    ("lean", "arms", "asked"),
    [(11.5, 0.0, True), (12.5, 0.0, False), (0.0, 29.0, True), (0.0, 31.0, False)],
)
def test_a_lean_is_asked_of_erect_trunks_with_level_arms(lean, arms, asked):
    way = [np.cos(np.radians(arms)), 0.0, -np.sin(np.radians(arms))]
    pose = pose_with_arms(way, way, [-way[0], *way[1:]], [-way[0], *way[1:]])
    dx = np.zeros(6 + 2 * len(JOINTS))
    dx[3] = np.radians(lean)
    rows = upright(displaced(pose, dx, JOINTS), 4)
    assert bool(rows) == asked
    if asked:
        np.testing.assert_allclose(rows[0].variance, 4.0 * np.radians(1.0) ** 2)


def _leg_data(reach, aside=0.05, count=20):
    """Data beside both shanks, from the knees down to some part of the whole leg's length."""
    frames, lengths, found = BODY.frames(STANDING), BODY.skeleton.lengths, []
    for thigh, shank in zip(THIGHS, SHANKS, strict=True):
        end = reach * (lengths[thigh] + lengths[shank]) - lengths[thigh]
        along = np.linspace(0.001, end, count)[:, None] * frames.rotations[shank, :, 2]
        out = aside * np.sign(frames.origins[shank, 0]) * np.array([1.0, 0.0, 0.0])
        found.append(frames.origins[shank] + along + out)
    return np.concatenate(found)


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"reach": 1.0}, True),
        ({"reach": 0.86}, True),
        ({"reach": 0.84}, False),
        ({"reach": 1.0, "aside": 0.119}, True),
        ({"reach": 1.0, "aside": 0.121}, False),
        ({"reach": 1.0, "count": 15}, True),
        ({"reach": 1.0, "count": 14}, False),
    ],
)
def test_a_leg_ends_where_the_data_of_its_shank_do(changed, told):
    data = _leg_data(**changed)
    found = soles(data, BODY, STANDING, 3)
    assert found.part.tolist() == (list(SHANKS) if told else [])
    frames = BODY.frames(STANDING)
    for shank, direction, measured in zip(found.part, found.direction, found.measured, strict=True):
        np.testing.assert_allclose(direction, frames.rotations[shank, :, 2])
        own = data[np.linalg.norm((data - frames.origins[shank])[:, :2], axis=1) < 0.13]
        assert measured == pytest.approx(np.percentile(own @ direction, 98.0), abs=1e-6)
    np.testing.assert_allclose(found.variance, 3.0 * 0.03**2)
    at = found.predicted(BODY, frames)
    for shank, direction, place in zip(found.part, found.direction, at, strict=True):
        end = frames.origins[shank] + BODY.skeleton.lengths[shank] * frames.rotations[shank, :, 2]
        assert place == pytest.approx(direction @ end)


@pytest.mark.parametrize(("degrees", "told"), [(24.0, True), (26.0, False)])
def test_bent_knees_leave_the_length_of_legs_open(degrees, told):
    rotations, data = STANDING.rotations.copy(), _leg_data(1.0)
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    for thigh in THIGHS:
        bend = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
        rotations[thigh] = rotations[thigh] @ bend
    for thigh, shank in zip(THIGHS, SHANKS, strict=True):
        rotations[shank] = rotations[thigh].T @ STANDING.rotations[thigh] @ rotations[shank]
    pose = dataclasses.replace(STANDING, rotations=rotations)
    frames, before = BODY.frames(pose), BODY.frames(STANDING)
    off = np.repeat(frames.origins[list(SHANKS)] - before.origins[list(SHANKS)], 20, axis=0)
    assert bool(len(soles(data + off, BODY, pose, 3).part)) == told
