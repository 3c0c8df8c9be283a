"""Tables of sweeps as they are looked at."""

import math

import numpy as np
import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.study.store import axis_of, curves_of, read_table
from stereotrack_core.tables import csv_text

COLUMNS = ("recording", "model_points", "views", "seed", "status", "forearms", "lost_recall", "job")


@pytest.fixture
def table(tmp_path):
    rows = []
    for i, points in enumerate((24, 120, 1000)):
        for j, views in enumerate(("NS", "NOSW")):
            for seed in (0, 1):
                value = 10.0 * i + 3.0 * j + seed
                rows.append(("r", str(points), views, str(seed), "done", str(value), "", "x"))
    rows.append(("r", "24", "NS", "2", "failed", "", "", "y"))
    path = tmp_path / "sweep.csv"
    path.write_text(csv_text(COLUMNS, rows), "utf-8")
    return read_table(path)


def test_what_was_varied_is_told_from_what_was_measured(table):
    assert table.varied == ("model_points", "views", "seed")
    assert table.settled == {"recording": "r"}
    assert table.measures == ("forearms",)
    assert (len(table.rows), table.failed) == (12, 1)
    assert table.values("model_points") == ("24", "120", "1000")
    assert table.values("views") == ("NS", "NOSW")
    assert table.common([0, 1]) == {"model_points": "24", "views": "NS"}
    assert table.best("forearms") == (0, 1)


def test_axes_are_of_numbers_or_of_words(table):
    axis = axis_of(table, "model_points")
    assert (axis.log, axis.words) == (True, False)
    assert axis.places == {"24": 24.0, "120": 120.0, "1000": 1000.0}
    assert axis_of(table, "views").places == {"NS": 0.0, "NOSW": 1.0}
    assert axis_of(table, "views").words


def test_curves_have_points_means_and_spread(table):
    few, many = curves_of(table, "model_points", "forearms", "views")
    assert (few.label, many.label) == ("views NS", "views NOSW")
    assert few.at.tolist() == [24, 120, 1000]
    assert few.mean.tolist() == [0.5, 10.5, 20.5]
    assert few.spread == pytest.approx(np.full(3, math.sqrt(0.5)))
    assert few.y.tolist() == [0, 1, 10, 11, 20, 21]
    assert [table.rows[i][2] for i in few.row] == ["NS"] * 6
    (one,) = curves_of(table, "views", "forearms")
    assert one.mean.tolist() == [10.5, 13.5]
    assert one.label == ""


@pytest.mark.parametrize(
    ("text", "words"), [("a,b\n1,2\n", "not a sweep table"), ("job,status\n1,failed\n", "no run")]
)
def test_other_tables_are_refused(tmp_path, text, words):
    (tmp_path / "x.csv").write_text(text)
    with pytest.raises(InputError, match=words):
        read_table(tmp_path / "x.csv")
