"""The tool that fits the coefficients finds those that data were drawn with."""

import importlib.util
import re
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.special import expit

from stereotrack_core.tracking.failure.coefficients import CONSTANTS, RESTS_ON, SLOPES
from stereotrack_core.tracking.failure.features import FEATURES

TOOL = Path(__file__).parents[3] / "tools" / "fit_lost_limbs.py"


@pytest.fixture
def tool(monkeypatch):
    monkeypatch.syspath_prepend(str(TOOL.parent))
    spec = importlib.util.spec_from_file_location("fit_lost_limbs", TOOL)
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, spec.name, module)
    spec.loader.exec_module(module)
    return module


def test_coefficients_are_found_again(tool, rng):
    signs = rng.normal(size=(30_000, 3)) * [1.0, 5.0, 0.2] + [0.0, 3.0, 1.0]
    true = np.array([-1.5, 1.2, -0.3, 4.0])
    lost = rng.random(len(signs)) < expit(true[0] + signs @ true[1:])
    np.testing.assert_allclose(tool.fitted(signs, lost, 3.0), true, rtol=0.1, atol=0.05)


def test_what_is_written_is_what_the_program_reads(tool):
    assert set(SLOPES) == set(CONSTANTS) == {"one", "several"}
    for slopes in SLOPES.values():
        assert set(slopes) == set(FEATURES)
    read: dict[str, object] = {}
    exec(tool.written(CONSTANTS, SLOPES, RESTS_ON), read)
    assert (read["CONSTANTS"], read["SLOPES"]) == (CONSTANTS, SLOPES)
    assert tool.WRITTEN.read_text() == tool.written(CONSTANTS, SLOPES, RESTS_ON)


def test_limbs_are_judged_by_other_recordings_with_and_without_keypoints(tool, rng):
    off = FEATURES.index("disagreement")
    signs = rng.normal(size=(400, 6, len(FEATURES)))
    degrees = np.where(rng.random((400, 6)) < expit(2.0 * signs[..., off] - 1.0), 60.0, 10.0)
    runs = [
        tool.Examples(name, "one", "fast", signs, degrees, np.full((400, 6), 5.0))
        for name in ("this", "other")
    ]
    judged = tool.left_out(runs)
    assert [each[0] for each in judged] == runs
    seen, blind = tool.tables("one", judged)
    lost = np.count_nonzero(degrees[:, tool.ARMS] > 45.0)
    assert seen.startswith(f"one, with detector: 3200 segments, {2 * lost} lost")
    area = [float(line.split("area ")[1].split(";")[0]) for line in (seen, blind)]
    assert area[0] > 0.8
    assert area[1] == pytest.approx(0.5, abs=0.1)


def test_the_calibration_error_is_that_of_bins_by_their_counts(tool):
    chance = np.repeat([0.05, 0.25, 0.95], [60, 30, 10])
    lost = np.zeros(100, dtype=bool)
    lost[60:75] = lost[90:] = True  # 0 of 60, 15 of 30, 10 of 10
    error = 0.6 * 0.05 + 0.3 * 0.25 + 0.1 * 0.05
    assert f"calibration error {error:.3f}" in tool.agreement(chance, lost)
    assert tool.area_under_roc(chance, lost) == pytest.approx((15 * (60 + 7.5) + 10 * 75) / 25 / 75)


def test_coverage_is_that_of_drawn_directions(tool, rng):
    degrees = np.linalg.norm(rng.normal(0.0, 5.0 / np.sqrt(2.0), (5000, 6, 2)), axis=2)
    run = tool.Examples(
        "a", "two", "fast", np.zeros((5000, 6, 1)), degrees, np.full((5000, 6), 5.0)
    )
    for line in tool.coverage([run]):
        inside = [float(x) for x in re.findall(r"(\d+) % within", line)]
        assert inside == pytest.approx([50.0, 90.0], abs=2.0)
