"""The set of landmarks is edited in a table; what is not usable is said at once."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QApplication, QColorDialog, QComboBox, QLineEdit

from app.features.annotate.setup.landmark_set import LandmarkSetDialog, sketch_of
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.project.clicks import PlaceClicks
from tests.gui.hands import double_click

LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def dialog(project, shown):
    return shown(LandmarkSetDialog(project), 1080, 520)


def edit_cell(qtbot, dialog, row, column, text):
    """Double click a cell (F2 for a colour), type, and press Enter."""
    area = dialog.table.visualRect(dialog.table.model().index(row, column))
    port = dialog.table.viewport()
    qtbot.mouseClick(port, LEFT, pos=area.center())
    if column == 1:
        qtbot.keyClick(dialog.table, Qt.Key.Key_F2)
    else:
        double_click(port, area.center())
    editor = QApplication.focusWidget()
    if isinstance(editor, QComboBox):
        editor.setCurrentText(text)
    else:
        assert isinstance(editor, QLineEdit)
        editor.selectAll()
        qtbot.keyClicks(editor, text)
    qtbot.keyClick(editor, Qt.Key.Key_Return)
    QApplication.processEvents()  # the editor hands its value on a moment later


def test_it_begins_with_the_nine(dialog):
    assert dialog.draft.checked() == NINE
    assert dialog.table.model().rowCount() == 9
    assert dialog.accept_button.isEnabled()


def test_a_landmark_is_added_named_and_used(qtbot, project, dialog):
    qtbot.mouseClick(dialog.add_button, LEFT)
    edit_cell(qtbot, dialog, 9, 0, "sternum")
    dialog.name.setFocus()
    dialog.name.selectAll()
    qtbot.keyClicks(dialog.name, "with sternum")
    assert "The keys 1 to 9 choose the first nine of 10" in dialog.words.text()
    qtbot.mouseClick(dialog.accept_button, LEFT)
    found = project.landmark_set()
    assert found.name == "with sternum"
    assert found.names == (*NINE.names, "sternum")
    project.undo()
    project.undo()
    assert project.landmark_set() == NINE


def test_a_slip_is_named_and_cannot_be_used(qtbot, dialog):
    edit_cell(qtbot, dialog, 2, 1, "red")
    assert "left_elbow: 'red' is not a colour. Write it as #rrggbb." in dialog.words.text()
    assert not dialog.accept_button.isEnabled()
    header = dialog.table.model().headerData(2, Qt.Orientation.Vertical)
    assert header == "3 !"
    edit_cell(qtbot, dialog, 2, 1, "#ff0000")
    assert dialog.words.text() == ""
    assert dialog.draft.landmarks[2].colour == "#ff0000"


def test_a_double_click_chooses_a_colour(qtbot, dialog):
    area = dialog.table.visualRect(dialog.table.model().index(0, 1))
    double_click(dialog.table.viewport(), area.center())
    chooser = dialog.findChild(QColorDialog)
    chooser.setCurrentColor(QColor("#123456"))
    chooser.accept()
    assert dialog.draft.landmarks[0].colour == "#123456"


def test_two_of_a_name_are_told(qtbot, dialog):
    edit_cell(qtbot, dialog, 6, 0, "left_hip")
    assert "2 landmarks have the name 'left_hip'" in dialog.words.text()


def test_the_mirror_follows_a_new_name(qtbot, dialog):
    edit_cell(qtbot, dialog, 2, 0, "left_funny_bone")
    assert dialog.draft.problem() is None
    assert dialog.draft.landmarks[3].mirror == "left_funny_bone"
    edit_cell(qtbot, dialog, 2, 4, "head")
    assert dialog.draft.problem() is None
    assert dialog.draft.landmarks[3].mirror == ""
    assert dialog.draft.landmarks[6].mirror == "left_funny_bone"


def test_limb_and_part_are_chosen_from_lists(qtbot, dialog):
    edit_cell(qtbot, dialog, 6, 2, "torso")
    assert dialog.draft.landmarks[6].limb == "torso"


def test_landmarks_are_moved_and_removed(qtbot, dialog):
    dialog.table.selectRow(8)
    for _ in range(2):
        qtbot.mouseClick(dialog.up_button, LEFT)
    assert dialog.draft.landmarks[6].name == "right_hip"
    qtbot.mouseClick(dialog.remove_button, LEFT)
    assert len(dialog.draft.landmarks) == 8
    assert dialog.draft.problem() is None  # the left hip has no mirror any more


def test_clicks_of_landmarks_that_are_left_out_are_told(qtbot, project, make, shown):
    project.apply(PlaceClicks(make.clicks_at([1, 2])))
    dialog = shown(LandmarkSetDialog(project), 1080, 520)
    dialog.table.selectRow(6)
    qtbot.mouseClick(dialog.remove_button, LEFT)
    assert dialog.warning.text().startswith(
        "Clicked but not in this landmark set: head (in 2 frames)."
    )


def test_files_are_exchanged(dialog, tmp_path, qtbot):
    qtbot.mouseClick(dialog.add_button, LEFT)
    longer = dialog.draft
    dialog.store(tmp_path / "set")
    dialog.table.selectRow(0)
    qtbot.mouseClick(dialog.remove_button, LEFT)
    dialog.load(tmp_path / "set.toml")
    assert dialog.draft == longer
    dialog.load(tmp_path / "none.toml")
    assert "no such file" in dialog.words.text()


def test_dots_are_where_landmarks_are(dialog):
    sketch = sketch_of(NINE.landmarks)
    places = {label: (x, y) for x, y, _, label in sketch.dots}
    assert places["left shoulder"][0] > 0 > places["right shoulder"][0]
    assert places["head"][1] < places["left shoulder"][1] < places["left hip"][1]
    drawn = {point.data(): point.pos() for point in dialog.sketch.dots.points()}
    assert (drawn["head"].x(), drawn["head"].y()) == pytest.approx(places["head"])
