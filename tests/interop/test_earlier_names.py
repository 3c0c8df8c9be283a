"""What a file of an earlier version calls otherwise is read as what it is."""

import numpy as np

from stereotrack_core.experiments.sweep.table import table_of_cells
from stereotrack_core.interop.run_npz import read_npz, write_npz


def test_a_run_keeps_its_unexplained_fraction_under_the_key_of_the_format(
    tmp_path, random, make_run
):
    run, path = make_run(random), tmp_path / "run.npz"
    write_npz(path, run)
    with np.load(path, allow_pickle=False) as stored:
        np.testing.assert_array_equal(stored["coverage"], run.unexplained_fraction)
        assert "unexplained_fraction" not in stored.files
    np.testing.assert_array_equal(read_npz(path).unexplained_fraction, run.unexplained_fraction)


def test_a_measure_of_an_earlier_table_is_no_parameter_that_was_varied():
    columns = ("iterations", "coverage", "status", "job")
    table = table_of_cells(columns, [("4", "8.5", "done", "a"), ("6", "7.5", "done", "b")], "x.csv")
    assert table.parameters == ("iterations",)
    assert table.measures == ("unexplained_fraction",)
