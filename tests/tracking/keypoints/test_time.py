"""Time goes by once: its noise is never taken back, and what belongs to a frame is used once."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.tracking.correspondences import DataToModel
from stereotrack_core.tracking.iekf import IteratedEstimator, PoseFilter
from stereotrack_core.tracking.initialise.finder import Candidate
from stereotrack_core.tracking.initialise.trunk import turned_round
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.state import Setup, State
from stereotrack_core.tracking.step_recorder import StepRecorder
from stereotrack_core.tracking.tracker import PersonTracker
from stereotrack_core.tracking.ukf import ThesisTracker
from tests.tracking.keypoints.cases import BODY, seen
from tests.tracking.scenes import CAMERAS, POSES, cloud_of, surface_points

TRUE = POSES["reaching"]
POINTS = surface_points(BODY, TRUE, 1200, np.random.default_rng(5), 0.005)
NOBODY = np.empty((0, 3))
DUST = np.random.default_rng(3).uniform([-3.0, -3.0, -1.0], [3.0, 3.0, 4.0], (3000, 3))
LANDMARKS = ("head", "left_hand", "right_hand")


def setup_of(name="fast", **changes):
    changes = {"search_arms": False, "data_points": 150, "iterations": 2} | changes
    return Setup(BODY, preset(name).replaced(**changes).tracking, CAMERAS, 2.0, 0)


def filter_of(*, listens=True, **changes):
    setup = setup_of(**changes)
    return PoseFilter(setup, IteratedEstimator(setup), DataToModel(setup), listens=listens)


def with_detections(cloud, *detections):
    return dataclasses.replace(cloud, detections=tuple(detections))


def heard_before(frame, *, off=0.0, sigma=0.02):
    """Detections at three instants between a frame and the one before."""
    times = (frame - 0.8, frame - 0.5, frame - 0.5, frame - 0.1)
    names = (*LANDMARKS, "head")
    return [seen(n, TRUE, time=t, sigma=sigma, off=off) for n, t in zip(names, times, strict=True)]


def assert_covariance(P):
    np.testing.assert_array_equal(P, P.T)
    assert np.linalg.eigvalsh(P).min() > 0.0


class Watch(StepRecorder):
    """Keeps from what was predicted, the covariance, and the pose."""

    def __init__(self, tracker):
        super().__init__(tracker.setup, None)
        self.told = []

    def predicted(self, before, predicted):
        if isinstance(before, State):
            self.told.append((before, predicted.P, predicted.pose))
        super().predicted(before, predicted)


class Doubtful(PersonTracker):
    """Turns round, and puts a pose on trial into the lead, whenever it is told to."""

    turns = exchanges = False

    def __init__(self):
        super().__init__(filter_of())
        self.finder.gain_of_turning = lambda pose, cloud: 1e9 if self.turns else 0.0
        self.finder.cost = self.cost

    def cost(self, pose, cloud):
        led = pose is self.pose
        return 100.0 if led and self.exchanges else 0.0

    def put_on_trial(self, pose):
        self._unchanged, self._age = 0, 100
        self._rivals = [Candidate(self.finder.follower(pose), 0.0)]


def led_by_the_rival(frames, *, detections):
    """A tracker that follows a wrong pose until the right one takes the lead in the last frame."""
    tracker = Doubtful()
    tracker.start(turned_round(TRUE))
    tracker.put_on_trial(TRUE)
    for cloud in frames:
        last = cloud is frames[-1]
        tracker.exchanges = last
        found = tracker.step(with_detections(cloud, *(detections if last else ())))
    return tracker, found


@pytest.mark.parametrize("heard", [(), heard_before(2)], ids=["alone", "with detections"])
def test_a_pose_that_takes_the_lead_is_estimated_as_if_it_had_always_led(heard):
    frames = [cloud_of(POINTS, k) for k in range(3)]
    _, found = led_by_the_rival(frames, detections=heard)
    tracker = filter_of()
    tracker.start(TRUE)
    for cloud in frames[:-1]:
        tracker.step(cloud)
    once = tracker.step(with_detections(frames[-1], *heard))
    np.testing.assert_array_equal(found.P, once.P)
    np.testing.assert_array_equal(found.x, once.x)
    assert found.prior is None


def test_turning_round_predicts_nothing_and_hears_nothing_again():
    tracker = Doubtful()
    watch = Watch(tracker)
    tracker.start(TRUE)
    tracker.step(cloud_of(POINTS, 7))
    tracker.turns = True
    tracker.step(with_detections(cloud_of(POINTS, 8), *heard_before(8)), watch)
    (_, heard, _), (state, predicted, pose) = watch.told
    assert np.trace(heard) < np.trace(predicted)
    assert state.time == 8
    assert pose is state.pose
    np.testing.assert_array_equal(predicted, state.P)


@pytest.mark.parametrize("kind", ["deaf", "listening", "thesis"])
def test_a_gap_between_frames_and_the_way_back_have_the_noise_of_their_time(kind):
    thesis = kind == "thesis"
    tracker = ThesisTracker(setup_of(kind)) if thesis else filter_of(listens=kind == "listening")
    tracker.start(TRUE)
    before = tracker.P if thesis else tracker.state.P
    for frame, gone in ((3, 1.0), (4, 1.0), (9, 5.0), (8, 1.0), (8, 0.0)):
        after = tracker.step(cloud_of(NOBODY, frame)).P
        np.testing.assert_allclose(after - before, gone * tracker.setup.Q, atol=1e-12)
        before = after


@pytest.mark.parametrize("points", [NOBODY, DUST], ids=["nobody", "dust"])
def test_a_frame_that_is_lost_has_taught_nothing(points):
    tracker = filter_of()
    tracker.start(TRUE)
    tracker.step(cloud_of(POINTS, 0))
    before = tracker.state
    lost = tracker.step(with_detections(cloud_of(points, 1), *heard_before(1)))
    assert not lost.tracked
    np.testing.assert_array_equal(lost.pose.rotations, before.pose.rotations)
    np.testing.assert_allclose(lost.P, before.P + tracker.setup.Q, atol=1e-12)


def test_detections_between_frames_belong_to_the_frame_in_the_backward_pass():
    tracker = filter_of(prior_inflation_above=100.0)
    tracker.start(TRUE)
    first = tracker.step(cloud_of(POINTS, 0))
    watch = Watch(tracker)
    found = tracker.step(with_detections(cloud_of(POINTS, 1), *heard_before(1)), watch)
    [(_, predicted, _)] = watch.told
    assert np.trace(predicted) < 0.9 * np.trace(first.P + tracker.setup.Q)
    np.testing.assert_allclose(found.prior.P, first.P + tracker.setup.Q, atol=1e-12)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(data=st.data())
@pytest.mark.parametrize("kind", ["filter", "doubtful", "thesis"])
def test_covariances_stay_positive_whatever_comes_and_goes(kind, data):
    kinds = {"filter": lambda: filter_of(listens=False), "doubtful": Doubtful}
    tracker = kinds.get(kind, lambda: ThesisTracker(setup_of("thesis")))()
    watch = Watch(tracker)
    tracker.start(TRUE)
    frame = data.draw(st.integers(20, 25))
    for _ in range(6):
        points = NOBODY if data.draw(st.integers(0, 4)) == 0 else POINTS
        times = data.draw(st.lists(st.floats(frame - 2.0, frame + 1.0), max_size=3))
        near = data.draw(st.booleans())
        detections = [
            seen(LANDMARKS[k], TRUE, time=time, sigma=0.01, off=0.0 if near else 3.0)
            for k, time in enumerate(times)
        ]
        if kind == "doubtful":
            tracker.turns, tracker.exchanges = data.draw(st.booleans()), data.draw(st.booleans())
            if data.draw(st.booleans()):
                tracker.put_on_trial(data.draw(st.sampled_from([TRUE, turned_round(TRUE)])))
        found = tracker.step(with_detections(cloud_of(points, frame), *detections), watch)
        assert_covariance(found.P)
        assert_covariance(tracker.state.P if kind == "filter" else tracker.P)
        for state, predicted, _ in watch.told:
            gone = 1.0 if state.time is None else abs(frame - state.time)
            without = state.P + gone * tracker.setup.Q
            assert np.linalg.eigvalsh(without - predicted).min() > -1e-9
            if not near:
                np.testing.assert_allclose(predicted, without, atol=1e-12)
        watch.told.clear()
        frame += data.draw(st.sampled_from([-1, 0, 1, 1, 1, 2, 7]))
