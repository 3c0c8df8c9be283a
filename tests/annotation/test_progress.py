"""Counts and lanes follow from clicks, flags and keyframes."""

from __future__ import annotations

from stereotrack_core.annotation.click import progress


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
