"""Time goes by once: its noise is never taken back, and what belongs to a frame is used once."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.tracking.iekf import Follower
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.state import Setup
from stereotrack_core.tracking.thesis import ThesisModel
from tests.tracking.keypoints.cases import BODY, seen
from tests.tracking.running import Stepping
from tests.tracking.scenes import CAMERAS, POSES, cloud_of, surface_points

TRUE = POSES["reaching"]
POINTS = surface_points(BODY, TRUE, 1200, np.random.default_rng(5), 0.005)
NOBODY = np.empty((0, 3))
LANDMARKS = ("head", "left_hand", "right_hand")


def setup_of(name="fast", **changes):
    changes = {"search_arms": False, "data_points": 150, "iterations": 2} | changes
    return Setup(BODY, preset(name).replaced(**changes).tracking, CAMERAS, 2.0, 0)


def filter_of(*, listens=True, **changes):
    setup = setup_of(**changes)
    return Stepping(Follower(setup, uses_async_detections=listens))


def thesis():
    return Stepping(ThesisModel(setup_of("thesis")))


@pytest.mark.parametrize("kind", ["deaf", "listening", "thesis"])
def test_a_gap_between_frames_and_the_way_back_have_the_noise_of_their_time(kind):
    tracker = thesis() if kind == "thesis" else filter_of(listens=kind == "listening")
    tracker.start(TRUE)
    before = tracker.P
    for frame, gone in ((3, 1.0), (4, 1.0), (9, 5.0), (8, 1.0), (8, 0.0)):
        after = tracker.step(cloud_of(NOBODY, frame)).P
        np.testing.assert_allclose(after - before, gone * tracker.setup.Q, atol=1e-12)
        before = after


def test_detections_between_frames_belong_to_the_frame_in_the_backward_pass():
    tracker = filter_of(prior_inflation_above=100.0)
    tracker.start(TRUE)
    first = tracker.step(cloud_of(POINTS, 0))
    times = {0.2: "head", 0.5: "left_hand", 0.9: "right_hand"}
    heard = tuple(seen(name, TRUE, time=time, sigma=0.02) for time, name in times.items())
    found = tracker.step(dataclasses.replace(cloud_of(POINTS, 1), detections=heard))
    np.testing.assert_allclose(found.prior.P, first.P + tracker.setup.Q, atol=1e-12)


@settings(max_examples=10, deadline=None, derandomize=True)
@given(data=st.data())
@pytest.mark.parametrize("kind", ["filter", "thesis"])
def test_covariances_stay_positive_whatever_comes_and_goes(kind, data):
    tracker = filter_of() if kind == "filter" else thesis()
    tracker.start(TRUE)
    frame = data.draw(st.integers(20, 25))
    for _ in range(6):
        points = NOBODY if data.draw(st.integers(0, 4)) == 0 else POINTS
        times = data.draw(st.lists(st.floats(frame - 2.0, frame + 1.0), max_size=3))
        off = data.draw(st.sampled_from([0.0, 3.0]))
        detections = tuple(
            seen(LANDMARKS[k], TRUE, time=time, sigma=0.01, off=off) for k, time in enumerate(times)
        )
        found = tracker.step(dataclasses.replace(cloud_of(points, frame), detections=detections))
        np.testing.assert_array_equal(found.P, found.P.T)
        assert np.linalg.eigvalsh(found.P).min() > 0.0
        frame += data.draw(st.sampled_from([-1, 0, 1, 1, 1, 2, 7]))
