"""Stretches: hysteresis, bridges and least lengths; what is joined, and its words."""

import numpy as np
import pytest

from stereotrack_core.evaluation.failure_segments.segment import (
    Stretch,
    high_stretches,
    joined,
    limbs_words,
)


def ends(value, least=1, bridge=0):
    found = high_stretches(np.arange(len(value)), np.array(value, float), 5.0, 3.0, least, bridge)
    return [(one.first, one.last) for one in found]


def test_stretches_last_until_values_are_low_and_gaps_are_bridged():
    assert ends([6, 4, 4, 2, 6]) == [(0, 2), (4, 4)]
    assert ends([6, 4, 4, 2, 6], least=2) == [(0, 2)]
    value = [6, 0, 0, 6, 0, 0, 0, 6]
    assert ends(value, bridge=2) == [(0, 3), (7, 7)]
    assert ends(value, bridge=3) == [(0, 7)]


def test_arms_are_joined_only_where_they_fail_at_the_same_time():
    long, short = Stretch(0, 30, 90.0, 5), Stretch(10, 14, 80.0, 11)
    apart = joined({"left_forearm": [long], "right_forearm": [short]}, "truth", "error")
    assert [e.limbs for e in apart] == [("left_forearm",), ("right_forearm",)]
    same = joined(
        {"left_forearm": [long], "right_forearm": [Stretch(2, 29, 95.0, 9)]}, "truth", "error"
    )
    assert [e.limbs for e in same] == [("left_forearm", "right_forearm")]
    assert (same[0].peak, same[0].peak_limb, same[0].peak_frame) == (95.0, "right_forearm", 9)


@pytest.mark.parametrize(
    ("limbs", "words"),
    [
        (("left_upper_arm", "left_forearm"), "left arm"),
        (("right_forearm",), "right forearm"),
        (
            ("torso", "left_forearm", "right_upper_arm", "right_forearm"),
            "torso, right arm, left forearm",
        ),
    ],
)
def test_both_halves_of_an_arm_are_an_arm(limbs, words):
    assert limbs_words(limbs) == words
