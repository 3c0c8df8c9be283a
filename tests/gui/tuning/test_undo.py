"""Undo by its keys, of all that a person does in the window, in the order in which it was done."""

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QInputDialog

from stereotrack_core.annotation.click import Click
from stereotrack_core.project.clicks import place
from tests.gui.hands import settle
from tests.gui.tuning.test_tuning import trigger, typed

pytestmark = pytest.mark.window
CTRL, SHIFT = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier


def press(modifiers=CTRL):
    """Ctrl+Z, or with Shift redo, wherever the focus is."""
    QTest.keyClick(QApplication.focusWidget(), Qt.Key.Key_Z, modifiers)


def named(window):
    """What Edit > Undo and Redo say that they do."""
    window.context.actions.refresh()
    return tuple(window.context.actions.action(name).text() for name in ("undo", "redo"))


def sigma(window):
    return window.context.session.track.settings.tracking.sigma_joint


def clicked(window, frame, camera="N_right"):
    window.context.session.project.apply(place(Click(frame, camera, "left_elbow", (100.0, 120.0))))


@pytest.fixture
def still(tuning):
    """The workspace Tune, where changes are not tried by themselves."""
    tuning.features.tune.toggle_live()
    tuning.activateWindow()
    return tuning


def test_keys_undo_clicks_and_parameters_in_their_order_and_go_where_they_are_seen(still, qtbot):
    docks, document = still.context.docks, still.context.session.document
    before = sigma(still)
    typed(still, "sigma_joint", "25")
    clicked(still, 5)
    typed(still, "sigma_joint", "30")
    assert named(still) == ("Undo Set sigma_joint to 30", "Redo")
    tip = still.context.actions.action("undo").toolTip()
    assert tip.startswith("Undo Set sigma_joint to 30. ")
    field = still.features.tune.parameters.line("sigma_joint").editor
    assert QApplication.focusWidget() is field, "what was typed was taken: undo is not the field's"
    press()
    assert (sigma(still), field.text(), docks.workspace) == (25.0, "25", "tune")
    assert still.statusBar().currentMessage() == "Undone: set sigma_joint to 30."
    assert named(still)[0] == "Undo Place left elbow in N_right, frame 5"
    press()
    assert (docks.workspace, document.frame) == ("annotate", 5)
    assert still.context.session.project.project.clicks.at(5) == ()
    assert named(still) == (
        "Undo Set sigma_joint to 25",
        "Redo Place left elbow in N_right, frame 5",
    )
    docks.views.tiles["N"].camera.setFocus()
    press()
    assert (sigma(still), docks.workspace) == (before, "tune")
    assert docks.is_seen("parameters")
    docks.timeline.setFocus()
    for _ in range(3):
        press(CTRL | SHIFT)
    assert sigma(still) == 30.0
    assert len(still.context.session.project.project.clicks.at(5)) == 1
    settle(still, qtbot)


def test_in_a_field_that_is_being_edited_the_keys_are_for_its_text(still):
    typed(still, "sigma_joint", "25")
    search = still.features.tune.parameters.search
    search.setFocus()
    search.selectAll()
    QTest.keyClicks(search, "loss")
    press()
    assert (search.text() != "loss", sigma(still)) == (True, 25.0)
    press(CTRL | SHIFT)
    assert (search.text(), sigma(still)) == ("loss", 25.0)
    field = still.features.tune.parameters.line("loss_scale").editor
    field.setFocus()
    QTest.keyClicks(field, "9")
    press()
    assert sigma(still) == 25.0
    QTest.keyClick(field, Qt.Key.Key_Escape)
    press()
    assert sigma(still) != 25.0, "nothing of the field's text is left to undo"


def test_changes_of_one_parameter_in_a_row_are_one_edit(still):
    before = still.context.session.track.settings
    for text in ("25", "30", "35"):
        typed(still, "sigma_joint", text)
    typed(still, "iterations", "5")
    still.features.tune.parameters.revert_all.click()
    assert named(still)[0] == "Undo Revert all parameters"
    press()
    press()
    assert named(still)[0] == "Undo Set sigma_joint to 35"
    press()
    assert still.context.session.track.settings == before
    assert named(still)[0] == "Undo"


def test_saving_a_preset_and_using_it_are_undone(still):
    parameters = still.features.tune.parameters
    typed(still, "sigma_joint", "25")
    trigger(still, "preset_save")
    dialog = still.findChild(QInputDialog)
    dialog.setTextValue("wide")
    dialog.accept()
    assert parameters.preset_box.currentText() == "wide"
    assert named(still)[0] == "Undo Use preset wide"
    press()
    press()
    assert still.features.tune.presets.own == ()
    assert parameters.preset_box.currentText() == still.context.session.track.preset != "wide"
    assert (named(still)[0], sigma(still)) == ("Undo Set sigma_joint to 25", 25.0)
    press(CTRL | SHIFT)
    press(CTRL | SHIFT)
    assert parameters.preset_box.currentText() == "wide"
    QTest.keyClick(parameters.preset_box, Qt.Key.Key_Home)
    parameters.preset_box.textActivated.emit("fast")
    assert named(still)[0] == "Undo Use preset fast"
    press()
    assert (parameters.preset_box.currentText(), sigma(still)) == ("wide", 25.0)


def test_closing_the_recording_ends_what_no_project_stores(still, qtbot):
    folder = still.context.session.document.recording.folder
    clicked(still, 3)
    typed(still, "sigma_joint", "25")
    still.context.session.document.close()
    assert named(still) == ("Undo", "Redo")
    still.context.session.open(folder)
    qtbot.waitUntil(lambda: still.context.session.project.project is not None)
    settle(still, qtbot)
    assert named(still) == ("Undo Place left elbow in N_right, frame 3", "Redo")
    assert sigma(still) == 25.0, "parameters are those of the window"
