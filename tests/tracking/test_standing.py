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
from tests.tracking.scenes import POSES, disturbed, pose_with_arms, surface_points

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


def test_nothing_is_asked_of_other_poses():
    assert upright(turned([np.radians(20.0), 0.0, 0.0]), 4) == ()
    others = [pose for name, pose in POSES.items() if name != "t"]
    assert len(others) > 1
    assert all(upright(pose, 4) == () for pose in others)
