"""How the time of a step grows with the points."""

import math

import pytest

from benchmarks.speed import cost_of_points, exponent
from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.tracking.presets import preset
from tests.tracking.recordings import write_depth_recording
from tests.tracking.scenes import POSES


def test_sizes_that_the_clouds_do_not_have_are_left_out(tmp_path):
    settings = preset("fast").replaced(speckle_size=0, search_arms=False)
    body = body_model(AVERAGE, settings.body)
    recording = write_depth_recording(tmp_path / "cones", body, [POSES["t"]] * 2)
    costs = dict(cost_of_points(recording, settings, (100, 1500, 10**6), frames=2))
    assert [*costs] == [100, 1500]
    assert all(ms > 0 for ms in costs.values())


def test_the_exponent_is_that_of_a_power():
    assert exponent([10, 20, 70], [3.0 * n**1.5 for n in (10, 20, 70)]) == pytest.approx(1.5)
    assert math.isnan(exponent([5], [1.0]))
