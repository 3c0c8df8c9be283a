"""Counts and lanes follow from clicks, flags and keyframes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stereotrack_core.annotation.click import UNCERTAIN, Click, Visibility
from stereotrack_core.annotation.progress import (
    lane_states,
    progress,
    seen,
)

HEAD = Click(2, "N", "head", (1.0, 2.0))
OUTSIDE = replace(HEAD, camera="S", position=None, visibility=Visibility.OUTSIDE)
HIP = replace(HEAD, landmark="left_hip")


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
    clicks = [
        HEAD,
        OUTSIDE,  # says something, but gives no position
        *(replace(HEAD, camera=camera, frame=3) for camera in "NS"),
        *(replace(HEAD, camera=camera, frame=4, flag=UNCERTAIN) for camera in "N"),
        replace(HIP, frame=3, deleted=True),
        replace(HIP, frame=99),
        replace(HIP, landmark="tail"),
    ]
    states = lane_states(
        seen(clicks),
        ["head", "left_hip"],
        7,
        flags=[(6, ""), (5, "left_hip"), (5, "tail"), (80, "head")],
        filled=[0, 3, 70],
    )
    np.testing.assert_array_equal(states, [[1, 0, 2, 3, 4, 0, 4], [1, 0, 0, 1, 0, 4, 4]])
