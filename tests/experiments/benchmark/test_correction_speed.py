"""The forms that are timed against each other do the same."""

import builtins
import importlib.util

import numpy as np
import pytest

from stereotrack_core.experiments.benchmark import speed as module
from stereotrack_core.experiments.benchmark.speed import (
    CorrectionSpeed,
    correction_speed,
    dense_form,
    difference,
    fast_form,
    filterpy_form,
    growth,
    make_problem,
)


@pytest.mark.parametrize("m", [3, 64, 256])
def test_forms_agree(m):
    problem = make_problem(m, seed=m)
    ours = fast_form(problem)
    assert np.linalg.norm(ours.dx) > 0
    assert difference(ours, dense_form(problem), problem.P) < 1e-9


@pytest.mark.parametrize("m", [3, 64])
def test_filterpy_agrees(m):
    pytest.importorskip("filterpy")
    problem = make_problem(m, seed=m)
    theirs = filterpy_form(problem)
    for _ in range(2):
        assert difference(fast_form(problem), theirs(), problem.P) < 1e-8


def test_without_filterpy(monkeypatch):
    find = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name: None if name == "filterpy" else find(name)
    )
    assert filterpy_form(make_problem(3)) is None
    told = []
    (speed,) = correction_speed([8], budget=0.01, on_progress=told.append)
    assert speed.filterpy_seconds is None
    assert speed.dense_seconds > 0
    assert speed.difference < 1e-9
    assert told == [1]


def test_growth_is_the_exponent():
    speeds = [CorrectionSpeed(m, 1e-6 * m**1.5, 1.0, None, 0.0) for m in (64, 256, 1024)]
    assert growth(speeds) == pytest.approx(1.5)
    assert module.STATES == 14
    assert builtins.max(module.MEASUREMENTS) == 4096


@pytest.mark.slow
def test_goals_of_the_correction():
    speeds = correction_speed()
    by_m = {speed.m: speed for speed in speeds}
    assert by_m[1024].dense_seconds / by_m[1024].seconds > 50
    assert growth(speeds) <= 1.05
