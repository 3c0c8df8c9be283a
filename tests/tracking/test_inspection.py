"""Beginning from what a run has kept gives the run's frame again, as far as it is kept."""

import types

import numpy as np
import pytest

from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.inspection import (
    FIRST,
    NOBODY,
    Known,
    Way,
    beginning_at,
    look_inside,
)
from stereotrack_core.tracking.presets import preset
from tests.tracking.scenes import CAMERAS, angle_errors
from tests.tracking.test_trace import KINDS, followed


def way_of(kind, tracker):
    name, changes = KINDS[kind]
    views = {str(k): types.SimpleNamespace(position_world=place) for k, place in enumerate(CAMERAS)}
    recording = types.SimpleNamespace(
        view=lambda name: name, reference_camera=views.__getitem__, fps=10.0, subject=None
    )
    return Way(recording, preset(name).replaced(**changes), tracker.setup.body, tuple(views), 3)


@pytest.mark.parametrize("kind", ["thesis", "fast"])
def test_a_stored_frame_begins_where_the_tracker_was(kind):
    tracker, cloud = followed(kind)
    before = Estimate(True, "", *state_of(tracker))
    found = beginning_at(way_of(kind, tracker), Known(before), cloud)
    trace = look_inside(found.tracker, cloud)
    own = look_inside(tracker, cloud)
    np.testing.assert_allclose(trace.predicted.P, own.predicted.P, rtol=1e-12)
    assert "covariance stored for the previous frame" in found.words
    if kind == "fast":  # nothing random but what goes by seed and frame
        np.testing.assert_allclose(trace.after.pose.rotations, own.after.pose.rotations, atol=1e-9)
        np.testing.assert_allclose(trace.after.P, own.after.P, rtol=1e-6)
    else:
        assert "random numbers" in found.words
        assert angle_errors(tracker.setup.body, trace.after.pose, own.after.pose).max() < 15.0


def state_of(tracker):
    return tracker.pose, np.zeros(len(tracker.P)), tracker.P


def test_a_first_frame_begins_with_its_own_pose():
    tracker, cloud = followed("fast")
    here = Estimate(True, "", *state_of(tracker))
    lost = Estimate(False, "nobody", *state_of(tracker))
    found = beginning_at(way_of("fast", tracker), Known(lost, None, here), cloud)
    assert found.words == FIRST
    np.testing.assert_array_equal(found.tracker.pose.position, here.pose.position)


@pytest.mark.parametrize("kind", ["thesis", "fast"])
def test_without_a_run_somebody_is_looked_for(kind):
    tracker, cloud = followed(kind)
    found = beginning_at(way_of(kind, tracker), Known(), cloud)
    assert found.words == NOBODY
    trace = look_inside(found.tracker, cloud)
    assert trace.estimate.tracked
    off = trace.after.pose.position - state_of(tracker)[0].position
    assert np.linalg.norm(off) < 0.15
