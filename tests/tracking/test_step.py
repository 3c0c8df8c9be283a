"""Decisions of a step: when a pose is given up, turned round, exchanged or not stated."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from stereotrack_core.tracking import step
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.iekf import Follower
from stereotrack_core.tracking.initialise.finder import TURN_GAIN, Candidate
from stereotrack_core.tracking.step import SETTLED, PersonModel
from tests.tracking.running import tracker_of
from tests.tracking.scenes import POSES, cloud_of, moved

POSE = POSES["t"]
CLOUD = cloud_of(np.zeros((0, 3)), 3)
FOUND = Estimate(True, "", POSE, np.zeros(3), np.eye(3))


@pytest.fixture
def model():
    setup = replace(tracker_of("manifold").setup, volume="the volume")
    return PersonModel(Follower(setup))


@pytest.mark.parametrize("unchanged", [SETTLED, SETTLED - 1])
@pytest.mark.parametrize("unconfirmed", [0, 2])
def test_a_body_is_partly_out_of_sight_by_its_support_and_its_points_at_the_sides(
    unchanged, unconfirmed, model, monkeypatch
):
    state = replace(model.first(POSE, 0), unchanged=unchanged, unconfirmed=unconfirmed)
    shown, doubt = {}, 1.0 if unchanged == SETTLED else 0.2
    monkeypatch.setattr(step, "trunk_support", lambda *_: shown["support"])
    monkeypatch.setattr(step, "share_at_sides", lambda *_: shown["cut"])
    monkeypatch.setattr(step, "depth_inside", lambda *_: np.array([2.0, shown["inside"]]))
    for support in (0.49, 0.51, 0.89, 0.91):
        for cut in (0.0, 0.0069, 0.0071, 0.029, 0.031, 0.034, 0.036, 0.149, 0.151):
            for inside in (0.09, 0.11):
                shown |= {"support": support, "cut": cut, "inside": inside}
                partly = cut > 0.15 * doubt or (support < 0.9 and cut > 0.035 * doubt)
                partly |= bool(unconfirmed) and inside < 0.1
                reason = model._why_partial(state, CLOUD)
                assert ("too little" in reason) == (support < 0.5)
                assert ("outside" in reason) == (support >= 0.5 and partly)
    nowhere = PersonModel(Follower(replace(model.setup, volume=None)))
    assert nowhere._why_partial(state, CLOUD) == ""


@pytest.mark.parametrize("seed", range(8))
def test_a_settled_pose_is_turned_round_by_lasting_evidence(seed, model, monkeypatch):
    rng, gain, doubt = np.random.default_rng(seed), [0.0], 0.0
    state, turned = model.first(POSE, 0), (SimpleNamespace(pose="turned"), FOUND)
    monkeypatch.setattr(model.finder, "gain_of_turning", lambda *_: gain[0])
    monkeypatch.setattr(model.follower.__class__, "tried", lambda *_: turned)
    for k in range(60):
        gain[0] = rng.normal(TURN_GAIN if k < 40 else 20.0, 40.0 if seed % 2 else 12.0)
        doubt += gain[0] - 3.0 if gain[0] < 3.0 else max(gain[0] - 8.0, 0.0)
        doubt = max(doubt, -200.0)
        state, _ = model._turned_if_wrong(state, FOUND, CLOUD, None)
        if doubt > 60.0:
            assert state.leader is turned[0]
            state, doubt = model.first(POSE, 0), 0.0
        assert state.doubt == pytest.approx(doubt)


@pytest.mark.parametrize(
    ("rival", "exchanged", "kept"),
    [(3.9, True, True), (4.1, False, True), (49.9, False, True), (50.1, False, False)],
)
def test_rivals_on_trial_are_taken_if_better_and_given_up_if_hopeless(
    rival, exchanged, kept, model, monkeypatch
):
    """The pose costs 10 by now: 8 of 10 before count, and 2 in this frame."""
    leader, other = model.follower.first(POSE, 3), model.follower.first(moved(POSE, [1, 0, 0]), 3)
    state = replace(model.first(POSE, 0), leader=leader, cost=10.0, unchanged=0, age=4)
    candidate = Candidate(other, other, rival)
    monkeypatch.setattr(model.finder, "cost", lambda *_: 2.0)
    monkeypatch.setattr(PersonModel, "_followed_rivals", lambda *_: [candidate])
    monkeypatch.setattr(Follower, "tried", lambda *_: (other, FOUND))
    found, _ = model._on_trial(state, FOUND, CLOUD, None)
    assert (found.leader is other) == exchanged
    assert found.cost == pytest.approx(rival if exchanged else 10.0)
    assert (found.age, found.unchanged) == (5, 0 if exchanged else 1)
    assert bool(found.rivals) == kept


def test_better_poses_that_are_found_later_are_compared_over_the_same_frames(model, monkeypatch):
    leader, other = model.follower.first(POSE, 3), model.follower.first(moved(POSE, [1, 0, 0]), 3)
    state = replace(model.first(POSE, 0), leader=leader, cost=10.0, unchanged=0, age=1)
    monkeypatch.setattr(model.finder, "cost", lambda *_: 2.0)
    monkeypatch.setattr(model.finder, "poses_of", lambda *_: [Candidate(other, other, 7.0)])
    found, _ = model._on_trial(state, FOUND, CLOUD, None)
    [rival] = found.rivals
    assert rival.cost == pytest.approx(7.0 * (1.0 + 0.8 + 0.64))
    monkeypatch.setattr(model.finder, "gain_of_turning", lambda *_: TURN_GAIN)
    monkeypatch.setattr(Follower, "step", lambda _, state, __: (state, FOUND))
    again, _ = model._on_trial(replace(found, age=2), FOUND, CLOUD, None)
    assert again.rivals[0].cost == pytest.approx(0.8 * rival.cost + 2.0)


@pytest.mark.parametrize(("metres", "left"), [(0.59, 1), (0.61, 2)])
def test_who_comes_back_is_confirmed_by_frames_in_which_hips_have_not_jumped(metres, left, model):
    """Hips move by 3 m/s at most: by 0.6 m in two frames of a tenth of a second."""
    before, pose = model.first(POSE, 1).leader, moved(POSE, [0.0, metres, 0.0])
    state = replace(model.first(pose, 3), unconfirmed=2)
    found = model._learned(state, before, CLOUD, CLOUD, FOUND)
    assert found.unconfirmed == left
