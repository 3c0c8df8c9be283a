"""Signs of failing limbs over time, and the probability that is made of them."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.evaluation.failure_segments.stretches import (
    SAID_SIGNS,
    failure_signs,
    lost_chances,
)
from tests.evaluation.failure_segments.runs import FPS, made, untracked

FOREARM = LIMBS.index("left_forearm")
BEFORE, AFTER = (SAID_SIGNS.index(name) for name in ("turned before", "turns after"))


def test_an_abrupt_turn_is_known_for_a_second_before_and_after():
    run, _ = made(wrong=[("left_forearm", 30, 59, 1.0)])
    signs = failure_signs(run, FPS, said=True)
    after, before = signs[:, FOREARM, AFTER] > 1.0, signs[:, FOREARM, BEFORE] > 1.0
    assert list(np.flatnonzero(after)) == list(range(20, 31))
    assert list(np.flatnonzero(before)) == list(range(30, 41))
    assert signs[30, FOREARM, BEFORE] == pytest.approx(np.log1p(np.degrees(1.0)), abs=1e-6)
    assert (signs[:, LIMBS.index("right_forearm"), BEFORE] < 1e-6).all()


def test_nothing_is_said_of_frames_without_a_pose_nor_of_torso_and_head():
    run, _ = made()
    for said in (True, False):
        signs = failure_signs(untracked(run, 10, 14), FPS, said=said)
        assert np.isnan(signs[10:15]).all()
        assert np.isnan(signs[:, :2]).all()
        rest = np.delete(signs[:, 2:], np.s_[10:15], axis=0)
        assert np.isfinite(rest).all()


@settings(max_examples=25, deadline=None)
@given(st.floats(0.0, 0.9), st.floats(0.0, 0.1), st.booleans())
def test_more_doubt_and_sharper_turns_never_lower_the_probability(lost, more, said):
    def chances(angle, chance):
        run, _ = made(
            frames=40, wrong=[("left_forearm", 15, 24, angle)],
            lost=[("left_forearm", 15, 24, chance)],
        )  # fmt: skip
        unknown = replace(run, limb_lost=np.full_like(run.limb_lost, np.nan))
        return lost_chances(run if said else unknown, FPS)[:, FOREARM]

    assert (chances(0.8, lost + more) >= chances(0.8, lost) - 1e-12).all()
    assert (chances(0.8 + more, lost) >= chances(0.8, lost) - 1e-12).all()


def test_a_limb_that_is_right_and_not_doubted_is_hardly_in_an_failure():
    run, _ = made()
    assert np.nanmax(lost_chances(run, FPS)) < 0.1
