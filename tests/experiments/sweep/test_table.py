"""Tables of sweeps as they are looked at."""

import math

import numpy as np
import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.experiments.sweep.table import (
    axis_of,
    best_cell,
    curves_of,
    draw_curves,
    draw_heat,
    heat_of,
    table_of_cells,
    words_of,
)

COLUMNS = ("recording", "model_points", "views", "seed", "status", "forearms", "lost_recall", "job")


@pytest.fixture
def table():
    rows = []
    for i, points in enumerate((24, 120, 1000)):
        for j, views in enumerate(("NS", "NOSW")):
            for seed in (0, 1):
                value = 10.0 * i + 3.0 * j + seed
                rows.append(("r", str(points), views, str(seed), "done", str(value), "", "x"))
    rows.append(("r", "24", "NS", "2", "failed", "", "", "y"))
    return table_of_cells(COLUMNS, rows, "sweep.csv")


def test_what_was_varied_is_told_from_what_was_measured(table):
    assert table.parameters == ("model_points", "views", "seed")
    assert table.settled == {"recording": "r"}
    assert table.measures == ("forearms",)
    assert (len(table.rows), table.failed) == (12, 1)
    assert table.values("model_points") == ("24", "120", "1000")
    assert table.values("views") == ("NS", "NOSW")
    assert table.chosen([0, 1]) == {"model_points": "24", "views": "NS"}


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


def test_heat_is_the_mean_of_each_pair(table):
    heat = heat_of(table, "model_points", "views", "forearms")
    assert heat.mean.tolist() == [[0.5, 10.5, 20.5], [3.5, 13.5, 23.5]]
    assert heat.rows[1][2] == (10, 11)
    assert best_cell(heat, "forearms") == (0, 0)
    assert best_cell(heat, "frames_per_second") == (1, 2)


def test_other_tables_are_refused():
    with pytest.raises(InputError, match="not a sweep table"):
        table_of_cells(("a", "b"), [("1", "2")], "x.csv")
    with pytest.raises(InputError, match="no job"):
        table_of_cells(COLUMNS, [], "x.csv")


@pytest.mark.parametrize("suffix", [".png", ".svg"])
def test_pictures_are_written(table, tmp_path, suffix):
    path = tmp_path / f"curves{suffix}"
    curves = curves_of(table, "model_points", "forearms", "views")
    draw_curves(path, axis_of(table, "model_points"), "forearms", curves)
    assert path.stat().st_size > 5000
    path = tmp_path / f"heat{suffix}"
    heat = heat_of(table, "model_points", "views", "forearms")
    heat.mean[0, 1] = np.nan
    draw_heat(path, ("model_points", "views"), "forearms", heat)
    assert path.stat().st_size > 5000
    assert words_of("forearms") == "forearms, mean [deg]"
    assert words_of("model_points") == "model points"
    assert words_of("sigma_joint") == "sigma joint [deg]"
