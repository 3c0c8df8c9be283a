import pytest
from PySide6.QtCore import QItemSelectionModel, Qt
from PySide6.QtGui import QGuiApplication

from app.widgets.style.colours import LIMB_COLOURS
from app.widgets.tables.panels import FindingsPanel, NumbersPanel
from stereotrack_core.errors import Finding

ROWS = [
    ("", "torso position", "67 mm", "from the reference"),
    ("left_forearm", "left forearm", "101.7 deg", "lost"),
    ("right_forearm", "right forearm", "14.2 deg", ""),
]


@pytest.fixture
def panel(shown):
    widget = NumbersPanel()
    widget.show_rows(ROWS)
    return shown(widget, 420, 200)


def text(panel, row, column):
    model = panel.table.model()
    return model.data(model.index(row, column))


def test_rows_are_shown(panel):
    assert [text(panel, 1, k) for k in range(3)] == ["left forearm", "101.7 deg", "lost"]


def test_no_column_is_narrower_than_its_words(panel):
    table = panel.table
    panel.show_rows([("head", f"landmark {k}", f"± {k}.{k}°", "good") for k in range(10)])
    for index in (table.model().index(row, k) for row in range(10) for k in range(2)):
        needed = table.sizeHintForIndex(index).width()
        assert table.sizeHintForColumn(index.column()) >= needed, index.data()


def test_limbs_colour_is_seen(panel):
    image = panel.table.viewport().grab().toImage()
    for row in (1, 2):
        cell = panel.table.visualRect(panel.table.model().index(row, 0))
        seen = {
            image.pixelColor(x, cell.center().y()).name() for x in range(cell.left(), cell.right())
        }
        assert LIMB_COLOURS[ROWS[row][0]].lower() in seen


def test_copying_takes_the_selection_or_all(qtbot, panel):
    assert panel.table.copied_text().count("\n") == 2
    model = panel.table.model()
    flags = (
        QItemSelectionModel.SelectionFlag.ClearAndSelect | QItemSelectionModel.SelectionFlag.Rows
    )
    panel.table.selectionModel().select(model.index(2, 0), flags)
    panel.table.setFocus()
    qtbot.keyClick(panel.table, Qt.Key.Key_C, Qt.KeyboardModifier.ControlModifier)
    assert QGuiApplication.clipboard().text() == "right forearm\t14.2 deg\t"


def test_a_listed_note_is_not_called_no_problem(shown):
    panel = FindingsPanel(lambda _finding: None)
    shown(panel, 420, 200).show_findings([Finding("note", "N", "it is dark", "Add light.")])
    assert panel.verdict.text() == "Usable, with 1 note."
