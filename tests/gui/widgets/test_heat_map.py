"""The matrix as colours: what is painted, and what is said about a cell."""

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from app.widgets.plots.step_plots import HeatMap, HeatMapView

VALUES = np.array([[1.0, 0.0, -1.0, 0.5], [0.0, 0.0, 0.0, -0.5]])


@pytest.fixture
def view(shown):
    made = HeatMapView()
    made.show_map(
        HeatMap(
            ("torso x", "head α"),
            (("torso", "torso", 2), ("head", "head", 2)),
            VALUES,
            lambda row, column: f"row {row} column {column}",
        )
    )
    return shown(made, 400, 160)


def colour(view, row, column):
    place = view.cell_place(row, column).toPoint()
    return view.grab().toImage().pixelColor(place)


def test_signs_have_hues_and_zero_has_none(view):
    high, low, zero = colour(view, 0, 0), colour(view, 0, 2), colour(view, 1, 0)
    assert high.red() > high.blue() + 80
    assert low.blue() > low.red() + 80
    assert max(zero.red(), zero.green(), zero.blue()) < 60, "as the dark background"
    weaker = colour(view, 0, 3)
    assert zero.red() < weaker.red() < high.red()


def test_mouse_and_arrow_keys_say_the_numbers(view, qtbot):
    said = []
    view.pointed.connect(said.append)
    for column in (1, 2):  # a mouse that rests there already would tell nothing
        place = view.cell_place(1, column).toPoint()
        QTest.mouseMove(view.windowHandle(), place)  # whatever other window lies there
    qtbot.waitUntil(lambda: view.words() == "row 1 column 2", timeout=3_000)
    QTest.keyClick(view, Qt.Key.Key_Up)
    QTest.keyClick(view, Qt.Key.Key_Right)
    QTest.keyClick(view, Qt.Key.Key_Right)
    assert view.words() == "row 0 column 3"
    assert said[-1] == "row 0 column 3"
