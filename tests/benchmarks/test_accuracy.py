"""Scores and rows of the accuracy benchmark, and what its ablations leave out."""

import dataclasses

import numpy as np
import pytest

from benchmarks.accuracy import ABLATIONS, contestants, row, score
from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.summary import evaluate
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory
from stereotrack_core.tracking.presets import PRESETS, preset
from stereotrack_core.tracking.run import track
from stereotrack_core.tracking.run_spec import RunSpec
from tests.tracking.recordings import write_depth_recording
from tests.tracking.scenes import POSES

SETTINGS = preset("fast").replaced(
    pixel_step=1, speckle_size=0, search_arms=False, data_points=300, fit_shape=False
)
SPEC = RunSpec(SETTINGS, frames=range(3), init="tpose")


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    folder = tmp_path_factory.mktemp("accuracy") / "cones"
    body = body_model(AVERAGE, SETTINGS.body)
    return write_depth_recording(folder, body, [POSES["t"]] * 4, missing={2})


def test_a_tracker_never_sees_the_reference_it_is_scored_against(recording):
    places = np.arange(3.0 * len(LANDMARKS)).reshape(-1, 3)
    wrong = LandmarkTrajectory(np.arange(4), np.tile(places, (4, 1, 1)))
    run = track(recording, SPEC)
    for reference in (recording.reference, wrong):
        values = score(dataclasses.replace(recording, reference=reference), SPEC)
        known = LandmarkTrajectory(reference.frame[:3], reference.points[:3])
        summary = evaluate(run, known)
        assert values["forearms"] == summary.measure("forearms").statistics.mean
        assert values["upper_arms_p95"] == summary.measure("upper_arms").statistics.p95
        assert values["lost"] == 100.0 * summary.lost
    with pytest.raises(InputError, match="no reference"):
        score(dataclasses.replace(recording, reference=None), SPEC)


def test_a_row_says_the_spread_where_there_is_one(recording):
    one = score(recording, SPEC)
    other = {name: value + 2.0 for name, value in one.items()}
    assert not any("±" in cell for cell in row("r", "a", [one]))
    assert "±" in row("r", "a", [one, other])[2]


@pytest.mark.parametrize("name", ABLATIONS)
def test_every_ablation_takes_something_away_from_accurate(name):
    values = contestants(None, [], ablation=True)
    for parameter in ABLATIONS[name]:
        assert values[name].values()[parameter] != values["accurate"].values()[parameter]
    assert [*contestants(None, [])] == [*PRESETS]
