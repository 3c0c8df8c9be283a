"""Legs as long as the person's, whatever lengths of the trunk lets expect."""

import dataclasses

import numpy as np
import pytest

from stereotrack_core.body.angles import ALL_JOINTS
from stereotrack_core.body.model import body_model
from stereotrack_core.body.parameters import BodyShape
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.skeleton import SHANKS, THIGHS
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.residuals.standing import soles
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


def test_shoulders_put_lower_leave_the_legs_as_long():
    low = dataclasses.replace(
        AVERAGE,
        torso_length=AVERAGE.torso_length - 0.1,
        shoulder_to_head=AVERAGE.shoulder_to_head + 0.1,
    )
    legs = [*THIGHS, *SHANKS]
    expected = BODY.skeleton.lengths[legs]
    assert body_model(low).skeleton.lengths[legs] == pytest.approx(expected)


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


def test_soles_are_measured_where_straight_legs_end(rng):
    long = with_legs(1.1)
    points = surface_points(long, STANDING, 2000, rng)
    rows = soles(points, BODY, STANDING, 3)
    assert rows.part.tolist() == list(SHANKS)
    lacking = rows.measured - rows.predicted(BODY, BODY.frames(STANDING))
    missing = sum(long.skeleton.lengths[p] - BODY.skeleton.lengths[p] for p in (6, 8))
    assert lacking == pytest.approx(missing, abs=0.025)


def test_bent_or_cut_legs_do_not_tell_their_length(rng):
    points = surface_points(BODY, seated(), 2000, rng)
    assert not len(soles(points, BODY, seated(), 3).part)
    points = surface_points(BODY, STANDING, 2000, rng)
    cut = points[points[:, 2] > BODY.frames(STANDING).origins[SHANKS[0], 2] - 0.25]
    assert not len(soles(cut, BODY, STANDING, 3).part)


def test_without_legs_nothing_is_asked(rng):
    bare = body_model(AVERAGE, BodyShape().replaced(legs=False))
    assert not len(soles(surface_points(BODY, STANDING, 500, rng), bare, STANDING, 3).part)
