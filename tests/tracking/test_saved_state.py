"""The state of a tracker is saved and restored whole."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.tracking.model import model_for
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.saved_state import check_like, restored, saved
from tests.same_run import assert_same_estimate
from tests.tracking.keypoints.test_reprojection import seen
from tests.tracking.running import Stepping
from tests.tracking.scenes import CAMERAS, POSES, cloud_of, surface_points, turned

PRESETS = ("thesis", "accurate", "annealed", "scalar", "keypoints")


def tracker_of(name):
    settings = preset("accurate" if name == "keypoints" else name)
    if name != "thesis":
        settings = settings.replaced(data_points=300, search_arms=False)
    body = body_model(AVERAGE, settings.body)
    model = model_for(body, settings, CAMERAS, 10.0, 0, clouds=name != "keypoints")
    tracker = Stepping(model)
    tracker.start(POSES["pointing"])
    return tracker


def clouds_of(tracker, count=5):
    """Coloured clouds of a body that turns slowly, with keypoints."""
    rng = np.random.default_rng(1)
    for k in range(count):
        pose = turned(POSES["pointing"], 2.0 * k)
        points = surface_points(tracker.setup.body, pose, 1200, rng, 0.005)
        colours = np.clip(points * 100.0 + 100.0, 0, 255)
        yield replace(cloud_of(points, k), colours=colours, keypoints=seen(pose))


@pytest.mark.parametrize("name", PRESETS)
def test_a_saved_state_is_restored_whole_after_an_abandoned_try(name):
    tracker = tracker_of(name)
    *first, second, third = clouds_of(tracker)
    for cloud in first:
        assert tracker.step(cloud).tracked
    before = tracker.state
    arrays = saved(before, "state")
    kept = {key: np.array(array) for key, array in arrays.items()}
    expected = tracker.step(second)
    tracker.step(replace(cloud_of(np.empty((0, 3)), 5), keypoints=None))
    if name in ("thesis", "accurate", "keypoints"):  # the others look for a body as accurate does
        tracker.step(third)
    for key, array in saved(before, "state").items():
        np.testing.assert_array_equal(array, kept[key], err_msg=f"a saved {key} has changed")
    check_like(before, kept, "state")
    tracker.state = restored(type(before), kept, "state")
    assert_same_estimate(tracker.step(second), expected)


@pytest.mark.parametrize("name", ["accurate", "thesis"])
def test_fifty_frames_in_any_order_are_resumed_and_watched_to_the_last_bit(name):
    tracker, states, found = tracker_of(name), [], []
    clouds = list(clouds_of(tracker, 60))
    for cloud in clouds:
        states.append(tracker.state)
        found.append(tracker.step(cloud))
    for k in np.random.default_rng(2).permutation(len(clouds))[:50]:
        state = restored(type(states[k]), saved(states[k], "state"), "state")
        tracker.state = state
        tracker.step(clouds[k - 7])  # a branch that leads elsewhere
        tracker.state = state
        assert_same_estimate(tracker.explain(clouds[k]).estimate, found[k])
        assert_same_estimate(tracker.step(clouds[k]), found[k])
