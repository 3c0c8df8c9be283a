"""Beginning from what a run has kept gives the run's frame again, as far as it is kept."""

import numpy as np
import pytest

from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.inspection import (
    FIRST,
    NOBODY,
    beginning_at,
    look_inside,
)
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.tracker import tracker_for
from tests.tracking.scenes import CAMERAS, angle_errors
from tests.tracking.test_trace import KINDS, followed


def new_tracker(kind, tracker):
    name, changes = KINDS[kind]
    settings = preset(name).replaced(**changes)
    return tracker_for(tracker.setup.body, settings, CAMERAS, 10.0, 3)


@pytest.mark.parametrize("kind", ["thesis", "fast"])
def test_a_stored_frame_begins_where_the_tracker_was(kind):
    tracker, cloud = followed(kind)
    before = Estimate(True, "", *state_of(tracker))
    new = new_tracker(kind, tracker)
    words = beginning_at(new, cloud, before)
    trace = look_inside(new, cloud)
    own = look_inside(tracker, cloud)
    np.testing.assert_allclose(trace.predicted.P, own.predicted.P, rtol=1e-12)
    assert "covariance stored for the previous frame" in words
    if kind == "fast":  # nothing random but what goes by seed and frame
        np.testing.assert_allclose(trace.after.pose.rotations, own.after.pose.rotations, atol=1e-9)
        np.testing.assert_allclose(trace.after.P, own.after.P, rtol=1e-6)
    else:
        assert "random numbers" in words
        assert angle_errors(tracker.setup.body, trace.after.pose, own.after.pose).max() < 15.0


def state_of(tracker):
    return tracker.pose, np.zeros(len(tracker.P)), tracker.P


def test_a_first_frame_begins_with_its_own_pose():
    tracker, cloud = followed("fast")
    here = Estimate(True, "", *state_of(tracker))
    lost = Estimate(False, "nobody", *state_of(tracker))
    new = new_tracker("fast", tracker)
    words = beginning_at(new, cloud, lost, here)
    assert words == FIRST
    np.testing.assert_array_equal(new.pose.position, here.pose.position)


@pytest.mark.parametrize("kind", ["thesis", "fast"])
def test_without_a_run_somebody_is_looked_for(kind):
    tracker, cloud = followed(kind)
    new = new_tracker(kind, tracker)
    words = beginning_at(new, cloud)
    assert words == NOBODY
    trace = look_inside(new, cloud)
    assert trace.estimate.tracked
    off = trace.after.pose.position - state_of(tracker)[0].position
    assert np.linalg.norm(off) < 0.15
