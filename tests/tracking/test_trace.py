"""A watched step is the tracker's own step, also where it begins from what a run has kept."""

import copy

import numpy as np
import pytest

from stereotrack_core.body.angles import THESIS_JOINTS
from stereotrack_core.body.model import body_model, landmarks
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.experiments.baselines import estimators, particles
from stereotrack_core.geometry.rotation import angle_between
from stereotrack_core.tracking.estimate import Estimate, limb_directions
from stereotrack_core.tracking.inspection import FIRST, NOBODY, beginning_at, explain
from stereotrack_core.tracking.model import model_for
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.saved_state import saved
from tests.same_run import assert_same_estimate
from tests.tracking.running import Stepping
from tests.tracking.scenes import CAMERAS, POSES, angle_errors, cloud_of, disturbed, surface_points

_QUICK = {"data_points": 500, "iterations": 3, "search_refined": 2}
KINDS = {
    "thesis": ("thesis", {}),
    "regular": ("thesis", {"sampling": "regular", "model_points": 40}),
    "accurate": ("accurate", _QUICK | {"search_proposals": 40}),
    "fast": ("fast", {"search_proposals": 30, "data_points": 300}),
    "ekf": ("ekf", {"data_points": 300}),
    "annealed": ("annealed", {}),
    "limb-icp": ("limb-icp", {"data_points": 300}),
    "scalar": ("scalar", {}),
}


@pytest.fixture(autouse=True)
def small_baselines(monkeypatch):
    """Every stage of the baselines at work, on little."""
    for module, name, value in (
        (particles, "LAYERS", 2),
        (particles, "PARTICLES", 40),
        (estimators, "ROUNDS", 2),
        (estimators, "STEPS", 5),
    ):
        monkeypatch.setattr(module, name, value)


def followed(kind, frames=1):
    """A tracker that has followed some frames, and the cloud that comes next."""
    name, changes = KINDS[kind]
    settings = preset(name).replaced(**changes)
    tracker = Stepping(model_for(body_model(AVERAGE, settings.body), settings, CAMERAS, 10.0, 3))
    rng = np.random.default_rng(7)
    clouds = [
        cloud_of(surface_points(tracker.setup.body, POSES["reaching"], 1000, rng, 0.004), k)
        for k in range(frames + 1)
    ]
    tracker.start(disturbed(POSES["reaching"], THESIS_JOINTS, rng))
    for cloud in clouds[:-1]:
        tracker.step(cloud)
    return tracker, clouds[-1]


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_a_watched_step_is_the_step_to_the_last_bit_and_leaves_the_tracker(kind):
    tracker, cloud = followed(kind)
    before = copy.deepcopy(saved(tracker.state, "state"))
    trace = tracker.explain(cloud)
    for name, array in saved(tracker.state, "state").items():
        np.testing.assert_array_equal(array, before[name])
    found = tracker.step(cloud)
    assert found.tracked
    assert trace.estimate.tracked
    assert_same_estimate(trace.estimate, found)
    np.testing.assert_array_equal(trace.after.P, found.P)


def test_the_true_arms_are_recorded_and_change_no_bit_of_the_step():
    tracker, cloud = followed("accurate")
    body = tracker.setup.body
    truth = landmarks(body, POSES["reaching"])
    trace, without = tracker.explain(cloud, truth), tracker.explain(cloud)
    assert_same_estimate(trace.estimate, without.estimate)
    np.testing.assert_array_equal(trace.after.P, without.after.P)
    for one, other in zip(trace.search.pairs, without.search.pairs, strict=True):
        assert one.terms == other.terms
    assert without.search.truth is None
    true = trace.search.truth
    for pair in (true.given, true.refined):
        assert pair.cost == pytest.approx(sum(pair.terms.values()))
        assert pair.terms.keys() == trace.search.followed.terms.keys()
    arms = limb_directions(body.frames(true.given.pose))[2:]
    there = limb_directions(body.frames(POSES["reaching"]))[2:]
    assert np.degrees(angle_between(arms, there)).max() < 12.0, "in the followed torso's frame"
    assert np.degrees(true.off).max() < 15.0
    assert (true.points > 10).all()
    nothing = np.full((9, 3), np.nan)
    assert tracker.explain(cloud, nothing).search.truth is None


@pytest.mark.parametrize("kind", ["thesis", "accurate"])
def test_iterations_lead_from_the_prediction_to_the_result(kind):
    tracker, cloud = followed(kind)
    trace = tracker.explain(cloud)
    assert trace.method == ("thesis" if kind == "thesis" else "manifold")
    first = trace.corrections[0]
    assert first.before.pose is trace.predicted.pose or kind == "thesis"
    np.testing.assert_array_equal(first.before.P, trace.predicted.P)
    np.testing.assert_allclose(trace.predicted.P, trace.before.P + tracker.setup.Q, rtol=1e-12)
    for a, b in zip(trace.corrections, trace.corrections[1:], strict=False):
        np.testing.assert_array_equal(a.after.P, b.before.P)
    assert len(trace.corrections) >= tracker.setup.parameters.iterations
    assert [c.iteration for c in trace.corrections][:3] == [1, 2, 3]
    kinds = {rows.kind for one in trace.corrections for rows in one.rows}
    assert kinds == ({"rest"} if kind == "accurate" else set())
    assert all(seconds >= 0.0 for seconds in trace.seconds.values())
    assert len(trace.state_names) == len(first.dx) == len(trace.after.P)


def new_tracker(kind, tracker):
    name, changes = KINDS[kind]
    settings = preset(name).replaced(**changes)
    return model_for(tracker.setup.body, settings, CAMERAS, 10.0, 3)


@pytest.mark.parametrize("kind", ["thesis", "fast"])
def test_a_stored_frame_begins_where_the_tracker_was(kind):
    tracker, cloud = followed(kind)
    before = Estimate(True, "", *state_of(tracker))
    new = new_tracker(kind, tracker)
    state, words = beginning_at(new, cloud, before)
    trace = explain(new, state, cloud)
    own = tracker.explain(cloud)
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
    state, words = beginning_at(new, cloud, lost, here)
    assert words == FIRST
    np.testing.assert_array_equal(state.pose.position, here.pose.position)


@pytest.mark.parametrize("kind", ["thesis", "fast"])
def test_without_a_run_somebody_is_looked_for(kind):
    tracker, cloud = followed(kind)
    new = new_tracker(kind, tracker)
    state, words = beginning_at(new, cloud)
    assert words == NOBODY
    trace = explain(new, state, cloud)
    assert trace.estimate.tracked
    off = trace.after.pose.position - state_of(tracker)[0].position
    assert np.linalg.norm(off) < 0.15
