"""What parts look like, and which part a datum belongs to by it."""

import numpy as np
import pytest

from stereotrack_core.body.model import body_model, placed_cones
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.skeleton import RIGHT_FOREARM, TORSO
from stereotrack_core.body.surface import nearest_on_surface, parts_of_cones
from stereotrack_core.tracking.correspondences import PartColours, colour_features
from stereotrack_core.tracking.residuals.surface import Trust, surface_residual
from tests.tracking.scenes import POSES, pose_with_arms, surface_points

BODY = body_model(AVERAGE)
TRUST = Trust(0.25, 0.06, 0.02, 150.0)
BLUE, ORANGE = (150.0, 80.0, 40.0), (40.0, 90.0, 170.0)
ARM_ON_CHEST = pose_with_arms([0.75, 0.3, -1.0], [-1.0, 0.35, 0.25], [-1, 0, 0], [-1, 0.05, 0])


def _clothed(pose, rng, count=4000):
    """Data of a body in a blue shirt with orange arms, and the true parts."""
    points = surface_points(BODY, pose, count, rng, 0.004)
    closest = nearest_on_surface(points, placed_cones(BODY, BODY.frames(pose)), np.inf)
    part = parts_of_cones(BODY, closest.cone)
    colours = np.where(np.isin(part, [2, 3, 4, 5])[:, None], ORANGE, BLUE)
    light = rng.uniform(0.8, 1.2, (len(part), 1))
    return points, part, colour_features(colours * light + rng.normal(0, 3.0, colours.shape))


@pytest.fixture
def known(rng):
    model = PartColours(BODY)
    for _ in range(3):
        points, _, features = _clothed(POSES["t"], rng)
        model.learn(points, features, BODY.frames(POSES["t"]))
    return model


def test_own_colours_differ_little_and_foreign_ones_much(known, rng):
    points, part, features = _clothed(ARM_ON_CHEST, rng)
    penalty = known.penalty(points, features, BODY.frames(ARM_ON_CHEST))
    cones = BODY.cones.part
    on_arm = part == RIGHT_FOREARM
    by_arm = penalty[on_arm][:, cones == RIGHT_FOREARM].min(axis=1)
    by_torso = penalty[on_arm][:, np.flatnonzero(cones == TORSO)[0]]
    assert np.median(by_arm) < 1.0
    assert np.median(by_torso) > 2.5


def test_nothing_is_said_of_what_is_not_known(rng):
    points, _, features = _clothed(POSES["t"], rng, 500)
    frames = BODY.frames(POSES["t"])
    np.testing.assert_array_equal(PartColours(BODY).penalty(points, features, frames), 1.0)
    model = PartColours(BODY)
    for _ in range(3):
        model.learn(points, features, frames)
    unseen = np.full_like(features, np.nan)
    np.testing.assert_array_equal(model.penalty(points, unseen, frames), 1.0)
    before = model.mean.copy()
    model.learn(points, unseen, frames)
    np.testing.assert_array_equal(model.mean, before)


def test_colours_tell_an_arm_from_the_chest_it_lies_on(known, rng):
    """The pose is a little wrong: by place alone much of the arm is given to the torso."""
    points, part, features = _clothed(ARM_ON_CHEST, rng)
    wrong = pose_with_arms([0.75, 0.3, -1.0], [-1.0, 0.2, 0.6], [-1, 0, 0], [-1, 0.05, 0])
    frames = BODY.frames(wrong)
    right = {}
    for name, penalty in (
        ("place", None),
        ("colour", 0.06 * known.penalty(points, features, frames)),
    ):
        closest = nearest_on_surface(points, placed_cones(BODY, frames), 0.25, penalty)
        found = parts_of_cones(BODY, closest.cone)
        right[name] = np.mean(found[part == RIGHT_FOREARM] == RIGHT_FOREARM)
    assert right["colour"] > right["place"] + 0.1


def test_no_penalty_and_the_same_for_all_change_nothing(rng):
    points, _, _ = _clothed(ARM_ON_CHEST, rng, 800)
    frames = BODY.frames(POSES["reaching"])
    plain = surface_residual(points, BODY, frames, TRUST)
    zero = np.zeros((len(points), len(BODY.cones)))
    for penalty in (zero, zero + 0.05):
        judged = surface_residual(points, BODY, frames, TRUST, penalty)
        np.testing.assert_array_equal(judged.part, plain.part)
        np.testing.assert_array_equal(judged.distance, plain.distance)


def test_features_ignore_brightness():
    colours = np.array([BLUE, ORANGE])
    plain, brighter = colour_features(colours), colour_features(1.5 * (colours + 10.0) - 10.0)
    np.testing.assert_allclose(brighter - plain, [[np.log(1.5), 0, 0]] * 2, atol=1e-12)
