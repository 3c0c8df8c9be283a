"""Which frames are held for a second look, and what one says, against their plain statement."""

from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.pose import t_pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.tracking.arm_search.arms import LEFT, with_arm
from stereotrack_core.tracking.estimate import Estimate, Prior
from stereotrack_core.tracking.frame import TrackedFrame, cloudless
from stereotrack_core.tracking.iekf import Follower
from stereotrack_core.tracking.run_spec import Hooks
from stereotrack_core.tracking.second_look import SecondLook, _Way, looked_again
from stereotrack_core.tracking.step import PersonModel
from tests.tracking.running import tracker_of

POSE = t_pose(np.array([0.0, 0.0, 1.0]))
BODY = body_model(AVERAGE)


def _frame(k, lost, *, tracked=True):
    expected = np.r_[0.9, 0.9, np.nan, np.nan, lost, np.nan]
    prior = Prior(np.eye(20), np.ones(20, dtype=bool))
    found = Estimate(tracked, "", POSE, np.zeros(3), np.eye(20), limb_lost=expected, prior=prior)
    return TrackedFrame(k, found, np.zeros((9, 3)), cloudless(k), {})


@pytest.mark.parametrize("seed", range(12))
def test_frames_are_held_from_before_the_first_doubtful_one_until_arms_are_sure(seed):
    rng, look = np.random.default_rng(seed), SecondLook(2)
    frames, held, expected, calm = [], [], 0.0, 0
    for k in range(130):
        quiet = rng.random() < (0.75 if seed % 3 else 0.2)
        lost, sure = (
            rng.uniform(0.0, 0.079) if quiet else rng.uniform(0.081, 0.16),
            rng.random() < 0.99,
        )
        frames.append(_frame(k, lost))
        look = look.with_frame(frames[-1], sure=sure)
        held = [*held, k] if sure else []
        calm = calm + 1 if quiet and sure else 0
        expected = (expected + (0.0 if quiet else lost)) if sure else 0.0
        due = expected >= 0.5 and len(held) > 1 and (calm >= 8 or len(held) > 100)
        if calm >= 8 and not due:
            expected = 0.0
        if expected == 0.0:
            held = held[-5:]
        assert [frame.frame for frame in look.held] == held
        assert look.expected == pytest.approx(expected)
        assert (look.calm, look.due) == (calm, due)
        assert look.pending == (expected >= 0.5 and len(held) > 1)
        assert look.first == (held[1] if len(held) > 1 else None)
        assert look.numbers().first == (held[0] if held else -1)
        again = SecondLook(2).restored(look.numbers(), frames)
        assert again.held == tuple(frames[j] for j in held)
        if due:
            assert look.frames == range(held[1], k + 1)
            look, held, expected, calm = look.forgotten(), [], 0.0, 0


def _bent(degrees):
    """The pose with the left forearm turned."""
    angle = np.radians(degrees)
    along = np.array([-np.cos(angle), np.sin(angle), 0.0])
    return with_arm(POSE, LEFT, np.array([-1.0, 0.0, 0.0]), along)


@pytest.mark.parametrize(("apart", "gain"), [(14, 21), (14, 19), (16, 21), (29, 21), (31, 21)])
def test_another_way_is_gone_where_it_agrees_and_is_better(apart, gain, monkeypatch):
    """The way gone is the cheaper one in the first frame, and the other one afterwards."""
    model, begun = PersonModel(Follower(tracker_of("manifold").setup)), {}
    stretch, from_state = tuple(_frame(k, 0.5) for k in range(4)), _Way.from_state
    look = SecondLook(1, (), stretch, 1.0)

    def begin(start, model, number):
        begun[number] = from_state(start, model, number)
        return begun[number]

    def follow(gone, tries, found, *_):
        [other] = tries
        gone.estimates, gone.costs = [frame.estimate for frame in found], [0.0, gain - 1.0, 1.0]
        other.costs = [100.0, 0.0, 0.0]
        other.estimates = [replace(one, pose=_bent(apart)) for one in gone.estimates]

    monkeypatch.setattr(_Way, "from_state", begin)
    monkeypatch.setattr("stereotrack_core.tracking.second_look._follow", follow)
    frames, state = lambda _: nullcontext(()), model.first(POSE, 0)
    _, after, found = looked_again(look, model, state, frames, Hooks())
    taken = gain > 20 and apart < 15
    assert after.changed == (((2, 3),) if taken else ())
    assert [frame.estimate.prior is None for frame in found] == [False, taken, False]
    assert begun[1].follower.setup.seed == model.setup.seed + 1000
    lost = [frame.estimate.limb_lost[4] for frame in found]
    assert lost == pytest.approx([0.1 if apart < 30 else 0.5] * 3)
