"""The benchmark of accuracy, on a recording of cones."""

import dataclasses
import math
from functools import partial

import numpy as np
import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.depth.chain import DepthChain
from stereotrack_core.errors import Cancelled, InputError
from stereotrack_core.evaluation.summary import evaluate
from stereotrack_core.experiments.benchmark import speed
from stereotrack_core.experiments.benchmark.accuracy import (
    MEASURES,
    Score,
    accuracy,
    pooled,
)
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run import track
from stereotrack_core.tracking.run_spec import RunSpec
from tests.tracking.recordings import write_depth_recording
from tests.tracking.scenes import pose_with_arms

FRAMES, MISSING = 6, 5
SMALL = {
    "pixel_step": 1,
    "speckle_size": 0,
    "search_arms": False,
    "data_points": 300,
    "fit_shape": False,
}


def pose(k):
    return pose_with_arms([1, 0.1 * k, 0], [1, 0.2 * k, 0], [-1, 0.1 * k, 0], [-1, 0.2 * k, 0.1])


def contestant(**changes):
    return preset("fast").replaced(**SMALL, **changes)


ALL = {
    "one": contestant(),
    "deeper": contestant(outlier_distance=50.0),
    "other": contestant(iterations=2),
}


def scored(recording, names, seeds, frames, **options):
    specs = {name: RunSpec(ALL[name], frames=frames, init="tpose") for name in names}
    return accuracy(recording, specs, seeds, **options)


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    body = body_model(AVERAGE, ALL["one"].body)
    folder = tmp_path_factory.mktemp("accuracy") / "cones"
    return write_depth_recording(folder, body, [pose(k) for k in range(FRAMES)], missing={MISSING})


@pytest.fixture(scope="module")
def scores(recording):
    return scored(recording, ALL, (0, 3), range(FRAMES))


def test_scores_are_those_of_runs_alone(recording, scores):
    assert [(s.contestant, s.seed) for s in scores] == [
        (name, seed) for name in ("one", "deeper", "other") for seed in (0, 3)
    ]
    for score in scores:
        run = track(recording, RunSpec(ALL[score.contestant], init="tpose", seed=score.seed))
        summary = evaluate(run, recording.reference)
        assert set(score.values) == set(MEASURES)
        for name in ("torso_position", "torso_long", "torso_cross", "upper_arms", "forearms"):
            assert score.values[name] == summary.measure(name).statistics.mean
        for name in ("upper_arms", "forearms"):
            assert score.values[f"{name}_p95"] == summary.measure(name).statistics.p95
        assert score.values["lost"] == 100.0 * summary.lost
        assert score.values["not_tracked"] == 100.0 * summary.not_tracked / summary.frames
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
    scored(recording, ("one", "other"), (0, 1), range(2))
    assert len(made) == 2
    made.clear()
    scored(recording, ALL, (0,), range(2))
    assert len(made) == 4


def test_no_tracker_sees_the_reference(recording):
    wrong = LandmarkTrajectory(
        np.arange(FRAMES), np.tile(np.arange(3.0 * len(LANDMARKS)).reshape(-1, 3), (FRAMES, 1, 1))
    )
    misled = dataclasses.replace(recording, reference=wrong)
    found = scored(misled, ("one",), (0,), range(3))[0]
    run = track(recording, RunSpec(ALL["one"], init="tpose", frames=range(3)))
    truth = LandmarkTrajectory(wrong.frame[:3], wrong.points[:3])
    summary = evaluate(run, truth)
    assert found.values["upper_arms"] == summary.measure("upper_arms").statistics.mean


def test_frames_outside_are_not_scored(recording):
    first = scored(recording, ("one",), (0,), range(2, 4))[0]
    assert first.frames == 2
    assert first.values["not_tracked"] == 0.0


def test_progress_is_told_and_stopping_ends_it(recording):
    told = []
    scored(recording, ("one", "deeper"), (0, 1), range(2), on_frames=told.append)
    assert told == [1] * 8
    with pytest.raises(Cancelled):
        scored(recording, ("one",), (0,), range(4), cancelled=lambda: True)


def test_recordings_without_a_usable_reference_are_refused(recording):
    with pytest.raises(InputError, match="no reference"):
        scored(dataclasses.replace(recording, reference=None), ("one",), (0,), range(2))
    late = LandmarkTrajectory(np.array([40]), np.zeros((1, len(LANDMARKS), 3)))
    with pytest.raises(InputError, match="none of the frames"):
        scored(dataclasses.replace(recording, reference=late), ("one",), (0,), range(2))


def score(seed, value, name="a", recording="r"):
    return Score(recording, name, seed, 7, dict.fromkeys(MEASURES, value))


def test_seeds_are_pooled():
    rows = pooled([score(0, 1.0), score(1, 2.0), score(2, 6.0), score(0, 5.0, "b")], {})
    assert [(row.contestant, row.seeds) for row in rows] == [("a", 3), ("b", 1)]
    assert rows[0].values["lost"].mean == 3.0
    assert rows[0].values["lost"].deviation == pytest.approx(math.sqrt(7.0))
    assert math.isnan(rows[1].values["lost"].deviation)
    assert pooled([score(0, 1.0), score(0, 1.0, recording="s")], {})[1].recording == "s"
    assert pooled([], {}) == ()


def test_speed_without_stereo_has_no_ratio(recording, monkeypatch):
    monkeypatch.setattr(speed, "RunSpec", partial(RunSpec, init="tpose"))
    told = []
    found = speed.chain_speed(
        recording,
        {name: ALL[name] for name in ("one", "other")},
        views=["N"],
        frames=2,
        rounds=1,
        on_progress=told.append,
    )
    assert [one.preset for one in found] == ["one", "other"]
    assert told == [1, 2]
    for one in found:
        assert one.seconds > 0
        assert math.isnan(one.ratio)
