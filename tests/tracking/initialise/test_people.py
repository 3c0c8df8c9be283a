"""Groups of points that stand apart, and which of them are the body's own."""

import numpy as np

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.tracking.initialise.people import own_points, people_in
from tests.tracking.scenes import POSES, surface_points

BODY = body_model(AVERAGE)


def _body(shift, count, rng):
    return surface_points(BODY, POSES["t"], count, rng) + shift


def test_two_people_are_two_groups_and_strays_are_none(rng):
    near, far = _body([0, 0, 0], 2000, rng), _body([0, 1.5, 0], 900, rng)
    stray = np.array([[1.7, -1.7, 0.3]])
    groups = people_in(np.concatenate([far, near, stray]), 150)
    assert [int(members.sum()) > 850 for members in groups] == [True, True]
    assert groups[0][900:-1].mean() > 0.98
    assert groups[1][:900].mean() > 0.98
    assert not any(members[-1] for members in groups)


def test_small_groups_are_nobody(rng):
    assert people_in(_body([0, 0, 0], 100, rng), 150) == []
    assert people_in(np.empty((0, 3)), 150) == []


def test_the_own_points_are_kept_and_those_of_somebody_else_are_not(rng):
    own, other = _body([0, 0, 0], 2000, rng), _body([0.1, 1.0, 0], 2000, rng)
    kept = own_points(np.concatenate([own, other]), BODY, POSES["t"])
    assert kept[:2000].all()
    assert kept[2000:].mean() < 0.05


def test_a_small_group_in_reach_is_kept_for_it_may_be_a_hand(rng):
    own = _body([0, 0, 0], 2000, rng)
    hand = np.array([0.2, 0.8, 1.3]) + rng.normal(0, 0.03, (60, 3))
    assert own_points(np.concatenate([own, hand]), BODY, POSES["t"])[2000:].all()


def test_nothing_is_nobodys(rng):
    assert own_points(np.empty((0, 3)), BODY, POSES["t"]).shape == (0,)
