"""The tool that fits the coefficients finds those that data were drawn with."""

import importlib.util
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
