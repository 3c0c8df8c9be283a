"""Limbs that lie elsewhere than what was seen are called lost, and the others are not."""

import dataclasses

import numpy as np
import pytest

from stereotrack_core.body.angles import ALL_JOINTS
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.skeleton import FOREARMS, UPPER_ARMS
from stereotrack_core.tracking.arm_search.arms import LEFT, RIGHT, with_arm
from stereotrack_core.tracking.estimate import Estimate, Prior
from stereotrack_core.tracking.failure import features
from stereotrack_core.tracking.failure.features import (
    FEATURES,
    bound,
    failure_probability,
    limb_features,
    unexpected,
    views_of_somebody,
)
from stereotrack_core.tracking.residuals.surface import Trust, surface_residual
from tests.tracking.scenes import POSES, surface_points
from tests.tracking.views import cloud_of_body

BODY = body_model(AVERAGE)
ARMS = [*UPPER_ARMS, *FOREARMS]
DOWN = np.array([0.0, 0.0, -1.0])


def found_at(pose, true, rng):
    """What a tracker would say that has settled at `pose` while `true` was seen."""
    frames = BODY.frames(pose)
    data = surface_points(BODY, true, 1200, rng, noise=0.01)
    pairs = surface_residual(data, BODY, frames, Trust(0.3, 0.06, 0.02, 150.0))
    joined = pairs.pairs()
    nothing = np.empty(0)
    return Estimate(
        True, "", pose, nothing, nothing, unexplained_fraction=0.1, correspondences=joined
    )


def features_of(cloud, found):
    return limb_features(cloud, BODY, found, np.full(6, 3.0), np.ones(6))


def signs_of(pose, true, rng):
    """Signs (6,) of each limb by their names."""
    signs = features_of(cloud_of_body(BODY, true), found_at(pose, true, rng))
    assert signs is not None
    assert np.isfinite(signs).all()
    return dict(zip(FEATURES, signs.T, strict=True)), failure_probability(signs, "several")


def test_coefficients_are_found_by_their_features_names(rng, monkeypatch):
    signs = rng.normal(size=(6, len(FEATURES)))
    before = failure_probability(signs, "one")
    turned = {views: dict(reversed(own.items())) for views, own in features.SLOPES.items()}
    monkeypatch.setattr(features, "SLOPES", turned)
    np.testing.assert_array_equal(failure_probability(signs, "one"), before)


@pytest.mark.parametrize("name", POSES)
def test_arms_where_they_were_seen_are_not_lost(name, rng):
    signs, lost = signs_of(POSES[name], POSES[name], rng)
    assert (lost[ARMS] < 0.2).all()
    assert (signs["through"][ARMS] < 0.05).all()
    assert (signs["behind"][ARMS] < 0.1).all()
    assert (signs["better"][ARMS] < 0.0).all()


@pytest.mark.parametrize("name", POSES)
@pytest.mark.parametrize("side", [LEFT, RIGHT])
def test_an_arm_beside_what_was_seen_is_lost(name, side, rng):
    true = POSES[name]
    out = np.array([-1.0 if side == LEFT else 1.0, 0.0, 0.0])
    along = DOWN + 0.15 * out if name == "t" else DOWN - 0.6 * np.array([0, 1, 0]) + 0.4 * out
    along /= np.linalg.norm(along)
    signs, lost = signs_of(with_arm(true, side, along, along), true, rng)
    wrong = [UPPER_ARMS[side], FOREARMS[side]]
    other = [UPPER_ARMS[1 - side], FOREARMS[1 - side]]
    assert lost[FOREARMS[side]] > 0.8
    assert lost[UPPER_ARMS[side]] > 0.4
    assert (lost[other] < 0.1).all()
    assert (signs["through"] + signs["behind"])[wrong].min() > 0.4
    assert (signs["better"][wrong] > 0.0).any()
    unexplained = signs["unexplained"][list(FOREARMS)]
    assert unexplained[side] > 2.0 * unexplained[1 - side]


def test_torso_and_head_have_no_probability(rng):
    _, lost = signs_of(POSES["t"], POSES["t"], rng)
    assert np.isnan(lost[: len(LIMBS) - len(ARMS)]).all()


def test_nothing_is_said_where_nobody_is_seen(rng):
    cloud = dataclasses.replace(cloud_of_body(BODY, POSES["t"]), depths={})
    assert features_of(cloud, found_at(POSES["t"], POSES["t"], rng)) is None
    assert np.isnan(failure_probability(None, "one")).all()


def test_jumps_are_stated_in_standard_deviations():
    n = 6 + 2 * len(ALL_JOINTS)
    P, movement = np.eye(n) * 0.2**2, np.zeros(n)
    first = 6 + 2 * ALL_JOINTS.index(FOREARMS[0])
    movement[first : first + 2] += [0.6, -0.6]
    prior = Prior(P, np.ones(n, dtype=bool))
    found = unexpected(movement, prior, ALL_JOINTS)
    assert found[FOREARMS[0]] == pytest.approx(3.0)
    assert np.delete(found, FOREARMS[0]) == pytest.approx(np.zeros(5), abs=1e-12)
    assert (unexpected(movement, None, ALL_JOINTS) == 0.0).all()


@pytest.mark.parametrize("views", ["one", "several"])
def test_a_limb_whose_surface_the_cloud_shows_is_never_called_lost(views, rng):
    """Whatever the other signs say: the cloud has the surface, and nothing else explains it."""
    signs = rng.normal(0.0, 20.0, (200, len(LIMBS), len(FEATURES)))
    signs[..., FEATURES.index("needed")] = np.log(0.45 + 0.05)
    signs[..., FEATURES.index("better")] = -0.2
    said = np.array([failure_probability(each, views) for each in signs])[:, ARMS]
    assert said.max() <= 0.5
    signs[..., FEATURES.index("better")] = 0.1  # it would be as good elsewhere
    free = np.array([failure_probability(each, views) for each in signs])[:, ARMS]
    assert free.max() > 0.99


def test_the_bound_falls_as_more_of_the_surface_is_seen():
    signs = np.zeros((5, len(FEATURES)))
    signs[:, FEATURES.index("better")] = -0.3
    signs[:, FEATURES.index("needed")] = np.log(np.array([0.0, 0.2, 0.3, 0.4, 0.9]) + 0.05)
    assert bound(signs) == pytest.approx([1.0, 1.0, 0.75, 0.5, 0.5])


def test_surfaces_that_another_limb_would_have_there_are_not_needed(rng):
    signs, _ = signs_of(POSES["t"], POSES["t"], rng)
    needed = np.exp(signs["needed"][ARMS]) - 0.05
    agreed = np.exp(signs["agreed"][ARMS]) - 0.05
    assert (needed <= agreed + 1e-9).all()
    assert (needed[2:] > 0.3).all()  # forearms that stand out
    cloud = cloud_of_body(BODY, POSES["t"])
    assert views_of_somebody(cloud) == ("one" if len(cloud.depths) == 1 else "several")
