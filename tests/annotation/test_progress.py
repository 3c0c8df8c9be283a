"""Counts and lanes follow from clicks, flags and keyframes."""

from __future__ import annotations

import numpy as np

from stereotrack_core.annotation.progress import Seen, lane_states, progress


def test_progress_is_told_in_a_sentence():
    keyframes = dict.fromkeys(range(300), False) | dict.fromkeys(range(214), True)
    found = progress(keyframes, {2, 5, 9, 5000}, 1)
    assert found.words() == "214 of 300 keyframes done, 3 flagged"
    assert found.clicks == 1
    assert found.share == 214 / 300
    assert progress({1: True}, (), 0).words() == "1 of 1 keyframes done"


def test_without_keyframes_clicks_are_counted():
    assert progress({}, (), 1).words() == "1 click, no keyframes set"
    assert progress({}, (), 2).words() == "2 clicks, no keyframes set"
    assert progress({}, (), 0).share == 0.0


def test_lanes_show_what_there_is():
    found = [
        Seen(2, "head", 1, False),
        Seen(2, "left_hip", 0, False),  # says something, but gives no position
        Seen(3, "head", 2, False),
        Seen(4, "head", 1, True),
        Seen(99, "left_hip", 1, False),
        Seen(2, "tail", 1, False),
    ]
    flags = [(6, ""), (5, "left_hip"), (5, "tail"), (80, "head")]
    states = lane_states(found, ["head", "left_hip"], 7, flags=flags)
    np.testing.assert_array_equal(states, [[0, 0, 1, 2, 3, 0, 3], [0, 0, 0, 0, 0, 3, 3]])
