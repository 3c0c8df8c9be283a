"""The descent on the sum of distances."""

import numpy as np

from stereotrack_core.body.angles import THESIS_JOINTS
from tests.tracking.peers.test_peers import make
from tests.tracking.scenes import POSES, disturbed, surface_points


def cost(tracker, data):
    surface = tracker.correspond(data, 2)
    scale = tracker.parameters.robust_narrow**2
    reach = tracker.parameters.reach
    e = np.append(surface.distance, np.full(len(data) - len(surface.distance), reach)) ** 2
    return np.mean(scale * e / (scale + e))


def test_the_sum_of_distances_falls_with_the_steps():
    rng = np.random.default_rng(0)
    start = disturbed(POSES["pointing"], THESIS_JOINTS, rng)
    found = []
    for steps in (1, 15, 120):
        tracker = make("scalar", scalar_iterations=steps)
        tracker.start(start)
        data = surface_points(tracker.body, POSES["pointing"], 2000, np.random.default_rng(1))
        before = cost(tracker, data)
        tracker.settle(0, data, tracker.P)
        found.append(cost(tracker, data))
    assert before > found[0] > found[1] > found[2]
    assert found[2] < 0.02 * before


def test_what_no_datum_speaks_about_does_not_move():
    tracker = make("scalar")
    tracker.start(POSES["pointing"])
    legless = surface_points(tracker.body, POSES["pointing"], 3000, np.random.default_rng(2))
    given = tracker.correspond(legless, 2)
    tracker.settle(0, given.data[given.part < 6], tracker.P)
    for leg in range(6, 10):
        turned = tracker.pose.rotations[leg].T @ POSES["pointing"].rotations[leg]
        assert np.degrees(np.arccos(np.clip(turned[2, 2], -1, 1))) < 10.0
    assert np.isfinite(tracker.P).all()
