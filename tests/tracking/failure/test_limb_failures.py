"""Limbs that lie elsewhere than what was seen are called lost, and the others are not."""

import functools

import numpy as np
import pytest

from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.body.skeleton import FOREARMS, UPPER_ARMS
from stereotrack_core.tracking.arm_search.arms import LEFT, RIGHT, with_arm
from stereotrack_core.tracking.failure.features import FEATURES, failure_probability, limb_features
from tests.tracking.scenes import POSES
from tests.tracking.views import cloud_of_body

BODY = body_model(AVERAGE)
ARMS = [*UPPER_ARMS, *FOREARMS]
DOWN = np.array([0.0, 0.0, -1.0])
NOTHING = np.zeros((len(LIMBS), 2))


@functools.cache
def cloud_of(name):
    return cloud_of_body(BODY, POSES[name])


def signs_of(pose, true, seen=NOTHING):
    """Signs (6,) of each limb by their names, and their probabilities."""
    signs = limb_features(cloud_of(true), BODY, pose, np.ones(6), seen)
    assert signs is not None
    assert np.isfinite(signs).all()
    return dict(zip(FEATURES, signs.T, strict=True)), failure_probability(signs, "several")


@pytest.mark.parametrize("name", POSES)
def test_arms_where_they_were_seen_are_not_lost(name):
    signs, lost = signs_of(POSES[name], name)
    assert (lost[ARMS] < 0.2).all()
    assert (signs["through"][ARMS] < 0.05).all()
    assert (signs["behind"][ARMS] < 0.1).all()
    assert (signs["better"][ARMS] < 0.0).all()


@pytest.mark.parametrize("name", POSES)
@pytest.mark.parametrize("side", [LEFT, RIGHT])
def test_an_arm_beside_what_was_seen_is_lost(name, side):
    true = POSES[name]
    out = np.array([-1.0 if side == LEFT else 1.0, 0.0, 0.0])
    along = DOWN + 0.15 * out if name == "t" else DOWN - 0.6 * np.array([0, 1, 0]) + 0.4 * out
    along /= np.linalg.norm(along)
    signs, lost = signs_of(with_arm(true, side, along, along), name)
    wrong = [UPPER_ARMS[side], FOREARMS[side]]
    other = [UPPER_ARMS[1 - side], FOREARMS[1 - side]]
    assert (lost[wrong] > 0.1).all()
    assert (lost[other] < 0.1 * lost[wrong].min()).all()
    contradicted = np.tile([0.5, 0.5], (6, 1))
    _, lost = signs_of(with_arm(true, side, along, along), name, contradicted)
    assert (lost[wrong] > 0.8).all()
    assert (signs["through"] + signs["behind"])[wrong].min() > 0.4
    assert (signs["better"][wrong] > 0.0).any()
    unexplained = signs["unexplained"][list(FOREARMS)]
    assert unexplained[side] > 2.0 * unexplained[1 - side]


@pytest.mark.parametrize("views", ["one", "two", "several"])
def test_keypoints_that_agree_make_surer_and_those_that_do_not_doubtful(views):
    pose, doubtful = POSES["t"], with_arm(POSES["t"], LEFT, DOWN, DOWN)
    cloud = cloud_of("t")
    for here, limbs in ((pose, ARMS), (doubtful, [UPPER_ARMS[LEFT], FOREARMS[LEFT]])):
        said = {}
        for name, off in (("agree", 0.1), ("contradict", 1.2)):
            seen = np.tile([off * 0.5, 0.5], (6, 1))
            signs = limb_features(cloud, BODY, here, np.ones(6), seen)
            said[name] = failure_probability(signs, views)[limbs]
        assert (said["agree"] < said["contradict"]).all()
