"""Signs of failing limbs over time, and the probability that is made of them."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.evaluation.failure_segments.stretches import (
    lost_chances,
)
from tests.evaluation.failure_segments.runs import FPS, made

FOREARM = LIMBS.index("left_forearm")


@settings(max_examples=25, deadline=None)
@given(st.floats(0.0, 0.9), st.floats(0.0, 0.1))
def test_more_doubt_and_sharper_turns_never_lower_the_probability(lost, more):
    def chances(angle, chance):
        run, _ = made(
            frames=40, wrong=[("left_forearm", 15, 24, angle)],
            lost=[("left_forearm", 15, 24, chance)],
        )  # fmt: skip
        return lost_chances(run, FPS)[:, FOREARM]

    assert (chances(0.8, lost + more) >= chances(0.8, lost) - 1e-12).all()
    assert (chances(0.8 + more, lost) >= chances(0.8, lost) - 1e-12).all()


def test_a_limb_that_is_right_and_not_doubted_is_hardly_in_an_failure():
    run, _ = made()
    assert np.nanmax(lost_chances(run, FPS)) < 0.1
