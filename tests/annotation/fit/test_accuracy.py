"""The figures of the documentation, on a recording with truth; seeds are fixed."""

import pytest

from stereotrack_core.annotation.fit.state import FitSettings
from stereotrack_core.annotation.fit.stretch import recorded_depth
from stereotrack_core.recording.folder import open_recording
from tests.annotation.simulated_clicks import ALONE, DEPTH, DIRTY, annotated

pytestmark = pytest.mark.slow


def means(score):
    names = ("upper_arms", "forearms", "torso_cross")
    return [score.summary.measure(name).statistics.mean for name in names]


def test_clicks_alone_are_as_good_as_documented(shared_recording):
    recording = open_recording(shared_recording("mesh-P4"))
    clean, dirty = (annotated(recording, case, 0, None) for case in (ALONE, DIRTY))
    for found, wanted in zip(means(clean), (4.2, 3.1, 2.6), strict=True):
        assert found < wanted
    for one, other in zip(means(clean), means(dirty), strict=True):
        assert other < 1.3 * one
    assert dirty.found >= 0.9
    assert dirty.accused <= 0.02
    for score in (clean, dirty):
        assert 0.9 < score.inside < 0.985
        assert 0.9 < score.limbs_inside < 0.995


def test_clicks_and_depth_are_as_good_as_documented(shared_recording):
    recording = open_recording(shared_recording("mesh-P4"))
    with recorded_depth(recording, FitSettings()) as depth:
        score = annotated(recording, DEPTH, 0, depth)
    for found, wanted in zip(means(score), (4.5, 4.6, 2.6), strict=True):
        assert found < wanted
    assert 0.9 < score.inside < 0.98
