"""What a file of an earlier version calls otherwise is read as what it is."""

import dataclasses

import numpy as np

from stereotrack_core.experiments.sweep.table import table_of_cells
from stereotrack_core.interop.run_npz import read_npz, write_npz
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.presets import read_preset
from stereotrack_core.tracking.repeating import changed_parameters


def test_a_run_keeps_its_unexplained_fraction_under_the_key_of_the_format(
    tmp_path, random, make_run
):
    run, path = make_run(random), tmp_path / "run.npz"
    write_npz(path, run)
    with np.load(path, allow_pickle=False) as stored:
        np.testing.assert_array_equal(stored["coverage"], run.unexplained_fraction)
        assert "unexplained_fraction" not in stored.files
    np.testing.assert_array_equal(read_npz(path).unexplained_fraction, run.unexplained_fraction)


def test_a_parameter_of_an_earlier_run_is_known_by_its_present_name(tmp_path, random, make_run):
    run, path = make_run(random), tmp_path / "run.npz"
    meta = {**run.meta, "parameters": {"lost_coverage": 0.7, "iterations": 5}}
    write_npz(path, dataclasses.replace(run, meta=meta))
    parameters = read_npz(path).meta["parameters"]
    assert parameters == {"max_unexplained_fraction": 0.7, "iterations": 5}
    assert changed_parameters(parameters, "accurate")["max_unexplained_fraction"] == (0.6, 0.7)


def test_a_parameter_of_an_earlier_preset_is_known_by_its_present_name(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text("[values]\nlost_coverage = 0.7\n")
    assert read_preset(path).settings.tracking.max_unexplained_fraction == 0.7


def test_a_measure_of_an_earlier_table_is_no_parameter_that_was_varied():
    columns = ("iterations", "coverage", "status", "job")
    table = table_of_cells(columns, [("4", "8.5", "done", "a"), ("6", "7.5", "done", "b")], "x.csv")
    assert table.parameters == ("iterations",)
    assert table.measures == ("unexplained_fraction",)


def test_a_value_may_be_given_by_the_earlier_name():
    assert Settings().replaced(lost_coverage=0.5) == Settings().replaced(
        max_unexplained_fraction=0.5
    )
