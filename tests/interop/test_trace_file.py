"""What happened inside a frame goes to files without loss."""

import csv

import numpy as np
import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.interop.trace_file import write_trace
from stereotrack_core.tracking.inspection import look_inside
from tests.tracking.test_trace import followed


@pytest.fixture(scope="module", params=["thesis", "fast"])
def trace(request):
    return look_inside(*followed(request.param))


def test_the_cross_covariance_comes_back_from_its_table(trace, tmp_path):
    write_trace(tmp_path / "pxz.csv", trace, 1)
    with (tmp_path / "pxz.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    correction = trace.corrections[1]
    read = [[float(row[f"P_xz_{name}"]) for row in rows] for name in trace.state_names]
    np.testing.assert_array_equal(read, correction.P_xz)
    residual = [float(row["residual_m"]) for row in rows]
    np.testing.assert_array_equal(residual, correction.points.residual)


def test_all_numbers_come_back(trace, tmp_path):
    write_trace(tmp_path / "frame.npz", trace, 0)
    with np.load(tmp_path / "frame.npz", allow_pickle=False) as stored:
        assert int(stored["corrections"]) == len(trace.corrections)
        for i, correction in enumerate(trace.corrections, start=1):
            np.testing.assert_array_equal(stored[f"correction_{i}_gain"], correction.gain)
            np.testing.assert_array_equal(stored[f"correction_{i}_after_P"], correction.after.P)
        np.testing.assert_array_equal(stored["after_position"], trace.after.pose.position)
        assert tuple(stored["state_names"]) == trace.state_names
        if trace.search is not None:
            costs = [pair.cost for pair in (trace.search.followed, *trace.search.pairs)]
            np.testing.assert_allclose(stored["search_costs"].sum(axis=1), costs)


def test_what_cannot_be_written_is_refused(trace, tmp_path):
    with pytest.raises(InputError, match="this type of file"):
        write_trace(tmp_path / "frame.xlsx", trace, 0)
    with pytest.raises(InputError, match="no cross-covariance"):
        write_trace(tmp_path / "frame.csv", trace, 99)
    assert not list(tmp_path.iterdir())
