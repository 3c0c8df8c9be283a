"""Pooled errors, also against figures that were computed independently."""

import numpy as np
import pytest

from stereotrack_core.evaluation.summary import errors_against, summarise_segments
from stereotrack_core.recording.description import Segment
from stereotrack_core.recording.landmarks import LandmarkTrajectory


def test_segments_and_empty_stretches():
    random = np.random.default_rng(0)
    reference = LandmarkTrajectory(np.arange(20), random.normal(0.0, 0.5, (20, 9, 3)))
    run = LandmarkTrajectory(np.arange(10), reference.points[:10])
    segments = [Segment("good", 0, 10), Segment("lost", 10, 20), Segment("outside", 50, 60)]
    good, lost, outside = summarise_segments(errors_against(run, reference), segments)
    assert good.lost == 0.0
    assert good.not_tracked == 0
    assert good.measure("forearms").statistics.p95 == pytest.approx(0.0, abs=1e-6)
    assert lost.lost == 1.0
    assert lost.not_tracked == 10
    assert lost.measure("torso_position").statistics.mean == pytest.approx(500.0)
    assert outside.frames == 0
    assert np.isnan(outside.lost)
    assert np.isnan(outside.measure("upper_arms").statistics.mean)
    with pytest.raises(KeyError):
        good.measure("tail")
