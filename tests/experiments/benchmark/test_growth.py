"""How cost grows, on a recording of cones."""

import math

import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.experiments.benchmark.growth import (
    cost_of_points,
    cost_of_views,
)
from stereotrack_core.experiments.benchmark.speed import exponent
from stereotrack_core.tracking.correspondences import DataToModel
from stereotrack_core.tracking.presets import preset
from tests.tracking.recordings import write_depth_recording
from tests.tracking.scenes import POSES

SETTINGS = preset("fast").replaced(speckle_size=0, search_arms=False)


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    body = body_model(AVERAGE, SETTINGS.body)
    folder = tmp_path_factory.mktemp("growth") / "cones"
    return write_depth_recording(folder, body, [POSES["t"]] * 4, missing={2})


def test_steps_are_timed_with_so_many_data_and_sizes_that_are_not_there_are_left_out(
    recording, monkeypatch
):
    used, choose = set(), DataToModel.choose

    def noted(tracker, cloud):
        data = choose(tracker, cloud)
        used.add(len(data))
        return data

    monkeypatch.setattr(DataToModel, "choose", noted)
    costs = cost_of_points(recording, SETTINGS, (100, 1500, 10**6), frames=4)
    assert [cost.size for cost in costs] == [100, 1500]
    assert min(used) == 100
    assert 1000 < max(used) <= 1500
    assert all(cost.milliseconds > 0 for cost in costs)


def test_every_number_of_views_has_its_cost(recording):
    costs = cost_of_views(recording, SETTINGS, frames=3)
    assert [cost.size for cost in costs] == [1, 2, 3, 4]
    assert [cost.size for cost in cost_of_views(recording, SETTINGS, views=["S", "N"])] == [1, 2]
    assert all(cost.milliseconds > 0 for cost in costs)


@pytest.mark.parametrize("power", [0.5, 1.0, 2.0])
def test_the_exponent_is_that_of_a_power(power):
    assert exponent([10, 20, 70], [3.0 * n**power for n in (10, 20, 70)]) == pytest.approx(power)


def test_one_size_has_no_exponent():
    assert math.isnan(exponent([5], [1.0]))
    assert math.isnan(exponent([], []))
