"""The forms of the correction that are timed against each other do the same; growth."""

import math

import pytest

from benchmarks.speed import (
    correction_table,
    cost_of_points,
    dense_form,
    difference,
    exponent,
    fast_form,
    filterpy_form,
    make_problem,
)
from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.tracking.presets import preset
from tests.tracking.recordings import write_depth_recording
from tests.tracking.scenes import POSES


@pytest.mark.parametrize("m", [3, 64])
def test_all_forms_of_the_correction_agree(m):
    pytest.importorskip("filterpy")
    problem = make_problem(m, seed=m)
    for form in (dense_form, filterpy_form):
        assert difference(fast_form(problem), form(problem), problem.P) < 1e-8


def test_the_table_of_corrections(capsys):
    correction_table([8, 16], budget=0.01)
    lines = capsys.readouterr().out.splitlines()
    assert [line.split("|")[1].strip() for line in lines[5:7]] == ["8", "16"]


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
