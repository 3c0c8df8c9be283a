"""Registration of one limb, and the joints that are imposed afterwards."""

import numpy as np

from stereotrack_core.body.skeleton import LEFT_FOREARM
from stereotrack_core.experiments.baselines import estimators
from stereotrack_core.geometry.rotation import rotation_from_vector
from tests.experiments.baselines.test_baselines import given, make
from tests.tracking.scenes import POSES, angle_errors, surface_points


def test_a_limb_is_moved_to_its_data_without_regard_to_its_joint(monkeypatch):
    rng = np.random.default_rng(0)
    monkeypatch.setattr(estimators, "ITERATIONS", 20)
    tracker = make("limb-icp")
    tracker.start(POSES["t"])
    body = tracker.setup.body
    points = surface_points(body, POSES["t"], 6000, rng)
    surface = given(tracker, points)[0].surface(POSES["t"], wide=False)
    arm = surface.data[surface.part == LEFT_FOREARM]
    origin = body.frames(POSES["t"]).origins[LEFT_FOREARM]
    turn, shift = rotation_from_vector(np.array([0.0, 0.08, 0.1])), np.array([0.0, 0.03, 0.04])
    moved = (arm - origin) @ turn.T + origin + shift
    register = tracker.model.follower.estimator.register
    found = register(LEFT_FOREARM, moved, POSES["t"], len(points))
    axis = turn @ body.frames(POSES["t"]).rotations[LEFT_FOREARM][:, 2]
    assert np.degrees(np.arccos(found.rotation[:, 2] @ axis)) < 1.0
    across = found.origin - (origin + shift)
    assert np.linalg.norm(across - (across @ axis) * axis) < 0.005
    assert np.linalg.eigvalsh(found.information).min() > -1e-6


def test_limbs_without_data_stay_where_they_are_expected():
    rng = np.random.default_rng(1)
    tracker = make("limb-icp")
    tracker.start(POSES["t"])
    points = surface_points(tracker.setup.body, POSES["t"], 4000, rng)
    surface = given(tracker, points)[0].surface(POSES["t"], wide=False)
    seen = surface.data[surface.part != LEFT_FOREARM]
    found = tracker.model.follower.estimator.settle(*given(tracker, seen))
    assert angle_errors(tracker.setup.body, found.pose, POSES["t"])[LEFT_FOREARM] < 3.0
    assert np.isfinite(found.P).all()
