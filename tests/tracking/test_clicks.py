"""Clicks as measurements of the tracker, and what they mend."""

import dataclasses
from dataclasses import dataclass

import numpy as np
import pytest

from stereotrack_core.body.manifold import displaced
from stereotrack_core.body.model import body_model, landmarks
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.experiments.tracked_run import TrackPlan, track_recording
from stereotrack_core.recording.detections import Detection, Detections
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.tracking.iekf import Follower
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.repair import repaired
from stereotrack_core.tracking.residuals.clicks import contradicted, pose_by_clicks
from stereotrack_core.tracking.run_spec import RunSpec
from stereotrack_core.tracking.state import Setup
from stereotrack_core.tracking.step import PersonModel
from tests.annotation.scenes import cameras
from tests.tracking.keypoints.cases import BODY
from tests.tracking.recordings import SMALL, write_depth_recording
from tests.tracking.running import Stepping
from tests.tracking.scenes import (
    CAMERAS,
    POSES,
    angle_errors,
    cloud_of,
    pose_with_arms,
    surface_points,
    turned,
)
from tests.tracking.test_smoothing import _followed, _pose

RIG = cameras("barrel")
HANGING = pose_with_arms([0.1, 0.1, -1], [0, 0.2, -1], [-0.1, 0.1, -1], [0, 0.2, -1])
SETTINGS = preset("accurate").replaced(
    search_arms=False, data_points=400, iterations=4, measure_silhouettes=False
)


def clicks_on(body, pose, frame=0, *, sigma=2.0, names=LANDMARKS, views=RIG, seed=0):
    """Clicks on landmarks in some views, as the tracker is given them."""
    places, rng = landmarks(body, pose), np.random.default_rng(seed)
    return tuple(
        Detection(
            float(frame),
            name,
            RIG[view].project(places[LANDMARKS.index(name)]) + rng.normal(0.0, sigma, 2),
            max(sigma, 1.0),
            camera=RIG[view],
        )
        for view in views
        for name in names
    )


def setup_of(body):
    return Setup(body, SETTINGS.tracking, CAMERAS, 10.0, 0)


@pytest.mark.parametrize("start", [turned(POSES["t"], 170.0, (0.8, 0.3, 0.0)), POSES["reaching"]])
def test_clicks_show_where_a_lost_body_is(start):
    true = POSES["pointing"]
    found = pose_by_clicks(setup_of(BODY), start, clicks_on(BODY, true))
    assert np.linalg.norm(found.position - true.position) < 0.03
    assert angle_errors(BODY, found, true).max() < 8.0
    assert contradicted(BODY, start, found)
    assert not contradicted(BODY, true, found)


def test_one_wrong_click_does_not_lead_astray():
    true, clicks = POSES["pointing"], list(clicks_on(BODY, POSES["pointing"]))
    k = next(i for i, one in enumerate(clicks) if one.kind == "right_hand")
    clicks[k] = dataclasses.replace(clicks[k], position=clicks[k].position + 150.0)
    found = pose_by_clicks(setup_of(BODY), true, tuple(clicks))
    assert angle_errors(BODY, found, true).max() < 8.0


def test_a_click_on_a_hand_moves_the_arm_rather_than_the_body():
    true, hand = POSES["t"], LANDMARKS.index("right_hand")
    (click,) = clicks_on(BODY, true, names=("right_hand",), views=("N",), sigma=0.0)
    lower = dataclasses.replace(click, position=click.position + [0.0, 80.0])
    found = pose_by_clicks(setup_of(BODY), true, (lower,))
    moved = landmarks(BODY, found) - landmarks(BODY, true)
    assert np.linalg.norm(moved[hand]) == pytest.approx(0.47, abs=0.03)
    assert np.linalg.norm(found.position - true.position) == pytest.approx(0.08, abs=0.03)


@pytest.fixture
def tracker():
    """A tracker of a whole person."""
    setup = setup_of(body_model(AVERAGE, SETTINGS.body))
    return Stepping(PersonModel(Follower(setup)))


def test_a_clicked_frame_brings_a_lost_body_back(tracker, rng):
    true = POSES["pointing"]
    tracker.start(turned(POSES["t"], 120.0, (0.3, 0.2, 0.0)))
    body = tracker.setup.body
    cloud = cloud_of(surface_points(body, true, 600, rng, 0.005))
    clicked = dataclasses.replace(cloud, clicks=clicks_on(body, true))
    estimate = tracker.step(clicked)
    assert estimate.tracked
    assert estimate.prior is None  # nothing of what came before is carried over
    assert angle_errors(body, estimate.pose, true).max() < 8.0
    again = tracker.step(dataclasses.replace(cloud, frame=1))
    assert again.prior is not None


@dataclass
class Course:
    """A run for :func:`repaired`, with clouds made again from the truth."""

    model: PersonModel
    spec: RunSpec

    @property
    def clouds(self):
        return self

    def take(self, frame) -> tuple[Cloud, float]:
        body, rng = self.model.setup.body, np.random.default_rng(frame)
        return cloud_of(surface_points(body, _pose(frame), 600, rng, 0.01), frame), 0.0


@pytest.mark.parametrize("smooth", [False, True])
def test_a_stretch_before_a_clicked_frame_is_repaired(tracker, rng, smooth):
    body = tracker.setup.body
    frames = _followed(Stepping(tracker.model.follower), rng, frames=10, points=600, noise=0.01)
    for k in range(3, 8):
        estimate = frames[k].estimate
        delta = np.zeros(len(estimate.P))
        delta[6:8] = 1.2, 0.4  # an arm somewhere else
        lost = displaced(estimate.pose, delta, tracker.setup.joints)
        wrong = dataclasses.replace(estimate, pose=lost)
        frames[k] = dataclasses.replace(frames[k], estimate=wrong, landmarks=landmarks(body, lost))
    frames[8] = dataclasses.replace(
        frames[8], estimate=dataclasses.replace(frames[8].estimate, prior=None)
    )
    spec = RunSpec(SETTINGS, clicks=Detections(clicks_on(body, _pose(8), 8)), smooth=smooth)
    found, mended = repaired(Course(tracker.model, spec), frames)
    assert set(range(3, 8)) <= set(mended) <= set(range(8))
    for frame in found:
        assert angle_errors(body, frame.pose, _pose(frame.frame)).max() < 12.0
        np.testing.assert_allclose(frame.landmarks, landmarks(body, frame.pose), atol=1e-9)
        assert frame.frame not in mended or frame.estimate.prior is None
    untouched, none = repaired(Course(tracker.model, RunSpec(SETTINGS)), frames)
    assert none == []
    assert untouched == frames


def test_a_whole_run_is_repaired_once_its_last_frame_is_there(tmp_path):
    settings = SMALL.replaced(measure_silhouettes=False, fit_shape=False)
    body = body_model(AVERAGE, settings.body)
    poses = [POSES["t"]] * 3 + [HANGING] * 5
    recording = write_depth_recording(tmp_path / "cones", body, poses)
    clicks = Detections(clicks_on(body, HANGING, 7), "clicks.csv")
    spec = RunSpec(settings, frames=range(8), init=POSES["t"], clicks=clicks)
    alone = track_recording(TrackPlan(recording, dataclasses.replace(spec, clicks=None))).run
    run = track_recording(TrackPlan(recording, spec)).run
    truth = recording.reference.points
    away = [np.linalg.norm(each.landmarks - truth, axis=2).max(axis=1) for each in (alone, run)]
    assert away[0][3:7].min() > 0.15, "without the search the arms are lost"
    assert run.meta["repaired"] == [3, 4, 5, 6]
    assert away[1][3:].max() < 0.1
