"""The benchmark of accuracy, on a recording of cones."""

import dataclasses
import math

import numpy as np
import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.depth.chain import DepthChain
from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.evaluation.errors import errors_against
from stereotrack_core.evaluation.summary import summarise
from stereotrack_core.experiments.benchmark.accuracy import (
    MEASURES,
    Contestant,
    Score,
    accuracy,
    pooled,
)
from stereotrack_core.experiments.benchmark.speed import speeds
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory
from stereotrack_core.tracking.pipeline import track
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run_spec import RunSpec
from tests.tracking.recordings import write_depth_recording
from tests.tracking.scenes import pose_with_arms

FRAMES, MISSING = 6, 5
SMALL = {"pixel_step": 1, "speckle_size": 0, "search_arms": False, "data_points": 300}


def pose(k):
    return pose_with_arms([1, 0.1 * k, 0], [1, 0.2 * k, 0], [-1, 0.1 * k, 0], [-1, 0.2 * k, 0.1])


def contestant(name, **changes):
    return Contestant(name, preset("fast").replaced(**SMALL, **changes))


ONE, OTHER = contestant("one"), contestant("other", iterations=2)
DEEPER = contestant("deeper", outlier_distance=50.0)


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    body = body_model(AVERAGE, ONE.settings.body)
    folder = tmp_path_factory.mktemp("accuracy") / "cones"
    return write_depth_recording(folder, body, [pose(k) for k in range(FRAMES)], missing={MISSING})


@pytest.fixture(scope="module")
def scores(recording):
    return accuracy(recording, (ONE, DEEPER, OTHER), (0, 3), range(FRAMES))


def test_scores_are_those_of_runs_alone(recording, scores):
    assert [(s.contestant, s.seed) for s in scores] == [
        (name, seed) for name in ("one", "deeper", "other") for seed in (0, 3)
    ]
    for score in scores:
        settings = {c.name: c.settings for c in (ONE, DEEPER, OTHER)}[score.contestant]
        run = track(recording, RunSpec(settings, seed=score.seed))
        summary = summarise(errors_against(run.trajectory(), recording.reference))
        assert score.values == {measure.name: measure.of(summary) for measure in MEASURES}
        assert score.frames == FRAMES
    assert len({tuple(score.values.values()) for score in scores}) == len(scores)


def test_frames_that_are_not_tracked_count_fully(scores):
    for score in scores:
        assert score.values["not_tracked"] == pytest.approx(100.0 / FRAMES)
        assert score.values["torso_position"] > 500.0 / FRAMES
        assert score.values["forearms"] > 90.0 / FRAMES
        assert score.values["lost"] == pytest.approx(100.0 / FRAMES)


def test_each_cloud_is_made_once_for_all_with_the_same_depth_parameters(recording, monkeypatch):
    made, whole = [], DepthChain.process
    monkeypatch.setattr(
        DepthChain, "process", lambda chain, images: made.append(images) or whole(chain, images)
    )
    accuracy(recording, (ONE, OTHER), (0, 1, 2), range(4))
    assert len(made) == 4
    made.clear()
    accuracy(recording, (ONE, DEEPER, OTHER), (0,), range(4))
    assert len(made) == 8


def test_no_tracker_sees_the_reference(recording):
    wrong = LandmarkTrajectory(
        np.arange(FRAMES), np.tile(np.arange(3.0 * len(LANDMARKS)).reshape(-1, 3), (FRAMES, 1, 1))
    )
    misled = dataclasses.replace(recording, reference=wrong)
    found = accuracy(misled, (ONE,), (0,), range(3))[0]
    run = track(recording, RunSpec(ONE.settings, frames=range(3)))
    truth = LandmarkTrajectory(wrong.frame[:3], wrong.points[:3])
    summary = summarise(errors_against(run.trajectory(), truth))
    assert found.values["upper_arms"] == summary.measure("upper_arms").statistics.mean


def test_frames_outside_are_not_scored(recording):
    first = accuracy(recording, (ONE,), (0,), range(2, 4))[0]
    assert first.frames == 2
    assert first.values["not_tracked"] == 0.0


def test_progress_is_told_and_stopping_ends_it(recording):
    told = []
    accuracy(recording, (ONE, DEEPER), (0, 1), range(3), on_progress=told.append)
    assert told == [2, 4, 6, 8, 10, 12]
    with pytest.raises(Cancelled):
        accuracy(recording, (ONE,), (0,), range(4), cancelled=lambda: True)


def test_recordings_without_a_usable_reference_are_refused(recording):
    with pytest.raises(InputError, match="no reference"):
        accuracy(dataclasses.replace(recording, reference=None), (ONE,), (0,), range(2))
    late = LandmarkTrajectory(np.array([40]), np.zeros((1, len(LANDMARKS), 3)))
    with pytest.raises(InputError, match="none of the frames"):
        accuracy(dataclasses.replace(recording, reference=late), (ONE,), (0,), range(2))


def score(seed, value, name="a", recording="r"):
    return Score(recording, name, seed, 7, {measure.name: value for measure in MEASURES})


def test_seeds_are_pooled():
    rows = pooled([score(0, 1.0), score(1, 2.0), score(2, 6.0), score(0, 5.0, "b")])
    assert [(row.contestant, row.seeds) for row in rows] == [("a", 3), ("b", 1)]
    assert rows[0].mean["lost"] == 3.0
    assert rows[0].spread["lost"] == pytest.approx(math.sqrt(7.0))
    assert math.isnan(rows[1].spread["lost"])
    assert pooled([score(0, 1.0), score(0, 1.0, recording="s")])[1].recording == "s"
    assert pooled([]) == ()


def test_speed_without_stereo_has_no_ratio(recording):
    told = []
    found = speeds(recording, (ONE, OTHER), frames=2, rounds=1, on_progress=told.append)
    assert list(found) == ["one", "other"]
    assert told == [1, 2]
    for speed in found.values():
        assert speed.frames_per_second > 0
        assert math.isnan(speed.ratio)
