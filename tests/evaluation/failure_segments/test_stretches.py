"""Stretches: hysteresis, bridges, least lengths; properties for any values."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stereotrack_core.evaluation.failure_segments.segment import limbs_words
from stereotrack_core.evaluation.failure_segments.stretches import Stretch, high_stretches, joined

VALUES = st.lists(
    st.one_of(st.just(float("nan")), st.floats(0.0, 10.0)), min_size=1, max_size=60
).map(np.array)


def ends(value, enter=5.0, leave=3.0, least=1, bridge=0, frame=None):
    value = np.array(value, dtype=float)
    frame = np.arange(len(value)) if frame is None else np.array(frame)
    return [(s.first, s.last) for s in high_stretches(frame, value, enter, leave, least, bridge)]


def test_gaps_are_bridged_up_to_their_length():
    value = [6, 0, 0, 6, 0, 0, 0, 6]
    assert ends(value, bridge=2) == [(0, 3), (7, 7)]
    assert ends(value, bridge=3) == [(0, 7)]


@given(VALUES, st.integers(1, 5), st.integers(0, 5))
def test_stretches_are_apart_long_enough_and_hold_what_is_high(value, least, bridge):
    found = high_stretches(np.arange(len(value)), value, 6.0, 4.0, least, bridge)
    for one, other in itertools.pairwise(found):
        assert other.first - one.last - 1 > bridge
    for stretch in found:
        assert stretch.last - stretch.first + 1 >= least
        assert stretch.peak > 6.0
        assert value[stretch.first] > 4.0
        assert value[stretch.last] > 4.0
    if least == 1:
        inside = np.zeros(len(value), dtype=bool)
        for stretch in found:
            inside[stretch.first : stretch.last + 1] = True
        assert not (value[~inside] > 6.0).any()


def _apart(pairs):
    """Stretches of one limb, which never share a frame, from their distances and lengths."""
    found, first = [], 0
    for distance, length in pairs:
        first += distance
        found.append(Stretch(first, first + length, 50.0 + length, first))
        first += length + 1
    return found


STRETCHES = st.lists(st.tuples(st.integers(0, 25), st.integers(0, 10)), max_size=3).map(_apart)


@given(st.fixed_dictionaries({"left_forearm": STRETCHES, "left_upper_arm": STRETCHES}))
def test_joined_failures_hold_every_stretch_and_halves_of_an_arm_do_not_overlap(stretches):
    failures = joined(stretches, "truth", "error")
    for limb, own in stretches.items():
        for stretch in own:
            assert any(
                limb in e.limbs and e.first <= stretch.first and stretch.last <= e.last
                for e in failures
            )
    for i, one in enumerate(failures):
        for other in failures[i + 1 :]:
            if set(one.limbs) != set(other.limbs):
                assert one.last < other.first or other.last < one.first


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
