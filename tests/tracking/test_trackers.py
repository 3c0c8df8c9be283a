"""What both trackers have in common: they follow a body whose pose is known."""

import numpy as np
import pytest

from stereotrack_core.body.angles import THESIS_JOINTS
from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.tracking.arm_search.search import ArmSearch
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.state import Setup
from tests.tracking.scenes import (
    POSES,
    angle_errors,
    cloud_of,
    disturbed,
    pose_with_arms,
    surface_points,
)

BOTH = pytest.mark.parametrize("name", ["thesis", "manifold"])


def _clouds(body, pose, rng, count, noise=0.005, points=2500):
    return [cloud_of(surface_points(body, pose, points, rng, noise), k) for k in range(count)]


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("pose", POSES)
@pytest.mark.parametrize(
    ("name", "largest_angle", "largest_shift"), [("thesis", 9.0, 0.03), ("manifold", 3.0, 0.006)]
)
def test_a_body_is_found_from_a_disturbed_start(
    make_tracker, name, largest_angle, largest_shift, pose, seed
):
    rng = np.random.default_rng(seed)
    tracker, true = make_tracker(name, seed=seed), POSES[pose]
    start = disturbed(true, THESIS_JOINTS, rng)
    tracker.start(start)
    for cloud in _clouds(tracker.setup.body, true, rng, 3):
        found = tracker.step(cloud)
    assert found.tracked
    assert not found.reason
    errors = angle_errors(tracker.setup.body, found.pose, true)
    assert errors.max() < largest_angle
    assert errors[2:].mean() < 0.5 * angle_errors(tracker.setup.body, start, true)[2:].mean()
    assert np.linalg.norm(found.pose.position - true.position) < largest_shift


def test_the_search_finds_an_arm_that_is_lost(make_tracker, rng):
    true = POSES["pointing"]
    lost = pose_with_arms([0.1, 0.1, -1], [0.1, 0.2, -1], [-0.9, 0.5, 0.4], [-0.3, 0.6, 1])
    tracker = make_tracker("manifold", search_arms=True)
    tracker.start(lost)
    assert angle_errors(tracker.setup.body, lost, true)[3] > 60
    for cloud in _clouds(tracker.setup.body, true, rng, 3):
        found = tracker.step(cloud)
    assert angle_errors(tracker.setup.body, found.pose, true)[2:].max() < 6.0


@pytest.mark.parametrize(("better", "kept"), [(2.9, True), (3.1, False)])
def test_other_arms_have_to_be_clearly_better(make_tracker, rng, monkeypatch, better, kept):
    costs = iter([10.0, *[10.0 - better] * 3])
    monkeypatch.setattr(ArmSearch, "cost", lambda *_: next(costs))
    tracker = make_tracker("manifold", search_arms=True)
    tracker.start(POSES["t"], -1.0, P=tracker.P)
    (cloud,) = _clouds(tracker.setup.body, POSES["t"], rng, 1)
    assert tracker.step(cloud).prior.carried.all() == kept


@BOTH
def test_a_moving_body_is_followed(make_tracker, rng, name):
    tracker = make_tracker(name, seed=5)
    tracker.start(POSES["t"])
    errors = []
    for k in range(8):
        bend = 0.12 * k
        true = pose_with_arms(
            [1, 0.6 * bend, -0.3 * bend],
            [1, 1.5 * bend, 0.1],
            [-1, 0.5 * bend, 0.4 * bend],
            [-1, 1.2 * bend, 0.1],
            place=(0.05 + 0.02 * k, -0.1, 0.95),
        )
        points = surface_points(tracker.setup.body, true, 2500, rng, 0.005)
        found = tracker.step(cloud_of(points, k))
        errors.append(angle_errors(tracker.setup.body, found.pose, true))
    assert np.max(errors) < (15.0 if name == "thesis" else 8.0)
    assert np.mean(errors) < (4.0 if name == "thesis" else 2.0)


@BOTH
def test_the_covariance_stays_symmetric_and_positive(make_tracker, rng, name):
    tracker = make_tracker(name)
    tracker.start(POSES["t"])
    sequence = [POSES[pose] for pose in ("t", "reaching", "pointing", "t", "reaching")]
    for k, true in enumerate(sequence * 2):
        found = tracker.step(cloud_of(surface_points(tracker.setup.body, true, 800, rng, 0.01), k))
        np.testing.assert_array_equal(found.P, found.P.T)
        assert np.linalg.eigvalsh(found.P).min() > 0
        assert found.P.shape == 2 * (len(found.x),)
        assert np.isfinite(found.limb_sigma_deg).all()


@BOTH
def test_too_few_points_are_not_tracked_and_it_goes_on_afterwards(make_tracker, rng, name):
    tracker, true = make_tracker(name, least_points=100), POSES["reaching"]
    tracker.start(true)
    full = _clouds(tracker.setup.body, true, rng, 3)
    assert tracker.step(full[0]).tracked
    for k, points in enumerate((np.empty((0, 3)), full[0].points[:99]), 1):
        lost = tracker.step(cloud_of(points, k))
        assert not lost.tracked
        assert f"{len(points)} points" in lost.reason
        assert np.isnan([lost.unexplained_fraction, lost.residual, lost.innovation]).all()
        assert lost.correspondences is None
    assert tracker.step(cloud_of(full[1].points[:100], 3)).tracked
    found = tracker.step(cloud_of(full[2].points, 4))
    assert found.tracked
    assert angle_errors(tracker.setup.body, found.pose, true).max() < 12.0


@BOTH
def test_the_same_seed_gives_the_same_to_the_last_bit(make_tracker, name):
    def run(seed):
        rng = np.random.default_rng(9)
        tracker = make_tracker(name, seed=seed)
        tracker.start(disturbed(POSES["reaching"], THESIS_JOINTS, rng))
        return [tracker.step(cloud) for cloud in _clouds(tracker.setup.body, POSES["t"], rng, 3)]

    first, again, other = run(4), run(4), run(5)
    for a, b in zip(first, again, strict=True):
        np.testing.assert_array_equal(a.x, b.x)
        np.testing.assert_array_equal(a.P, b.P)
        assert (a.unexplained_fraction, a.residual, a.innovation) == (
            b.unexplained_fraction,
            b.residual,
            b.innovation,
        )
    assert (first[-1].x != other[-1].x).any()


@BOTH
def test_signs_of_trust_tell_a_good_pose_from_a_bad_one(make_tracker, rng, name):
    tracker = make_tracker(name)
    points = surface_points(tracker.setup.body, POSES["t"], 2500, rng, 0.005)
    tracker.start(POSES["t"])
    good = tracker.step(cloud_of(points))
    half = np.concatenate([points, points[points[:, 0] > 0.5] + [0, 0, 0.6]])
    tracker.start(POSES["t"])
    bad = tracker.step(cloud_of(half))
    assert 0 < good.unexplained_fraction < 0.05
    assert bad.unexplained_fraction > good.unexplained_fraction + 0.02
    assert good.residual < 0.02
    pairs = good.correspondences
    assert pairs.data.shape == pairs.model.shape == (len(pairs.part), 3)
    assert ((pairs.weight > 0) & (pairs.weight <= 1)).all()


def setup_with(parameters, fps):
    """Of a whole body, whose shoulders come last in the state."""
    return Setup(body_model(AVERAGE), parameters, np.zeros((1, 3)), fps, 0)


@pytest.mark.parametrize("fps", [5.0, 120.0])
def test_variances_grow_with_the_time_between_frame_sets(fps):
    p = TrackingParameters()
    np.testing.assert_allclose(setup_with(p, fps).Q, setup_with(p, 10.0).Q * 10.0 / fps)


def test_trackers_use_their_frame_rate(make_tracker):
    for name in ("thesis", "manifold"):
        np.testing.assert_allclose(
            make_tracker(name, fps=5).setup.Q, 2 * make_tracker(name, fps=10).setup.Q
        )
