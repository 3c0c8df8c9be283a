"""The descent on the sum of distances."""

import numpy as np

from stereotrack_core.body.angles import THESIS_JOINTS
from stereotrack_core.experiments.baselines import estimators
from tests.experiments.baselines.test_baselines import given, make
from tests.tracking.scenes import POSES, disturbed, surface_points


def cost(tracker, data, pose):
    surface = given(tracker, data)[0].surface(pose, wide=False)
    scale = tracker.setup.parameters.loss_scale**2
    reach = tracker.setup.parameters.max_correspondence_distance
    e = np.append(surface.distance, np.full(len(data) - len(surface.distance), reach)) ** 2
    return np.mean(scale * e / (scale + e))


def test_the_sum_of_distances_falls_with_the_steps(monkeypatch):
    rng = np.random.default_rng(0)
    start = disturbed(POSES["pointing"], THESIS_JOINTS, rng)
    found = []
    for steps in (1, 15, 120):
        monkeypatch.setattr(estimators, "STEPS", steps)
        tracker = make("scalar")
        tracker.start(start)
        data = surface_points(tracker.setup.body, POSES["pointing"], 2000, np.random.default_rng(1))
        before = cost(tracker, data, start)
        settled = tracker.model.follower.estimator.settle(*given(tracker, data))
        found.append(cost(tracker, data, settled.pose))
    assert before > found[0] > found[1] > found[2]
    assert found[2] < 0.02 * before
