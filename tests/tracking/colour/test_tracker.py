"""Tracking with colours."""

from dataclasses import replace

import numpy as np

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.tracking.correspondences import DataToModel
from stereotrack_core.tracking.iekf import IteratedEstimator, PoseFilter
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.state import Setup
from stereotrack_core.tracking.tracker import PersonTracker
from tests.tracking.scenes import CAMERAS, POSES, angle_errors, cloud_of, surface_points

BODY = body_model(AVERAGE)


def _clouds(rng, count=3):
    clouds = [cloud_of(surface_points(BODY, POSES["t"], 2500, rng, 0.006), k) for k in range(count)]
    return [replace(c, colours=rng.uniform(30.0, 200.0, c.points.shape)) for c in clouds]


def _tracked(clouds, *, coloured=True, **changes):
    setup = Setup(BODY, preset("fast").replaced(**changes).tracking, CAMERAS, 10.0, 0)
    correspondences = DataToModel(setup, coloured=coloured)
    tracker = PersonTracker(PoseFilter(setup, IteratedEstimator(setup), correspondences))
    tracker.start(POSES["t"])
    return [tracker.step(cloud) for cloud in clouds], tracker


def test_without_weight_or_colours_nothing_differs_bit_for_bit(rng):
    clouds = _clouds(rng)
    plain, _ = _tracked(clouds, coloured=False)
    unweighted, _ = _tracked(clouds)
    grey = [replace(cloud, colours=None) for cloud in clouds]
    without, _ = _tracked(grey, colour_weight=0.06)
    for a, b, c in zip(plain, unweighted, without, strict=True):
        for other in (b, c):
            np.testing.assert_array_equal(a.x, other.x)
            np.testing.assert_array_equal(a.P, other.P)


def test_colours_are_learned_and_senseless_ones_do_no_harm(rng):
    found, tracker = _tracked(_clouds(rng), colour_weight=0.06)
    assert all(estimate.tracked for estimate in found)
    assert tracker.memory()["colour_count"].sum() > 500
    assert angle_errors(BODY, found[-1].pose, POSES["t"])[[0, 2, 3, 4, 5]].max() < 6.0
    assert found[-1].correspondences.data.shape[1] == 3
