"""Undo by its keys, of all that a person does in the window, in the order in which it was done."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QInputDialog, QLineEdit

from app.features.tune.presets import NameDialog
from app.session.runs import entry_of_run
from stereotrack_core.annotation.click import Click
from stereotrack_core.interop.run_file import read_run
from stereotrack_core.project.clicks import place
from stereotrack_core.project.runs import kept_runs
from tests.gui.tuning.test_tuning import names, standing_still, tried, trigger, typed, unix

pytestmark = pytest.mark.window
CTRL, SHIFT = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier


def press(modifiers=CTRL):
    """Ctrl+Z, or with Shift redo, wherever the focus is."""
    QTest.keyClick(QApplication.focusWidget(), Qt.Key.Key_Z, modifiers)


def named(window):
    """What Edit > Undo and Redo say that they do."""
    window.context.actions.refresh()
    return tuple(window.context.actions.action(name).text() for name in ("undo", "redo"))


def settle(window, qtbot):
    qtbot.waitUntil(window.context.tasks.settled, timeout=60_000)


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
    series = still.features.tune.series_panel
    still.context.docks.bring_up("series")
    for widget in (series.count, series.parameter):
        widget.setFocus()
        press(CTRL | SHIFT)
        assert sigma(still) == 25.0, widget
        press()
        assert sigma(still) != 25.0, widget


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


@unix
def test_a_parameter_is_undone_while_its_trial_is_tracked(tuning, qtbot):
    before, trials = sigma(tuning), tuning.features.tune.trials
    with standing_still(tuning):
        typed(tuning, "sigma_joint", "25")
        qtbot.waitUntil(lambda: trials.running is not None)
        press()
        assert (sigma(tuning), trials.running, names(tuning)) == (before, None, [])
        press(CTRL | SHIFT)
        qtbot.waitUntil(lambda: trials.running is not None)
    settle(tuning, qtbot)
    assert (sigma(tuning), names(tuning)) == (25.0, ["sigma joint 25 deg"])
    typed(tuning, "sigma_joint", "30")
    settle(tuning, qtbot)
    press()
    assert sigma(tuning) == 25.0, "a value with a trial of its own is a step"
    settle(tuning, qtbot)
    both = ["sigma joint 25 deg", "sigma joint 30 deg"]
    assert names(tuning) == both, "results stay until they are discarded"


@unix
def test_a_trial_that_was_asked_for_is_undone_and_tracked_again(still, qtbot):
    typed(still, "sigma_joint", "25")
    with standing_still(still):
        trigger(still, "trial_now")
        assert named(still)[0] == "Undo Run trial sigma joint 25 deg"
        press()
        assert (names(still), sigma(still)) == ([], 25.0)
        press(CTRL | SHIFT)
        assert still.features.tune.trials.running is not None
        typed(still, "sigma_joint", "30")
        assert names(still) == [], "a change ends the trial in progress"
        press()
        assert sigma(still) == 25.0
        assert "Run trial" not in named(still)[0], "and nothing of it is left to be undone"
    trigger(still, "trial_now")
    settle(still, qtbot)
    (trial,) = still.features.tune.trials.entries
    press()
    press(CTRL | SHIFT)
    assert still.features.tune.trials.entries == (trial,)
    assert (still.features.tune.trials.running, len(trial.frames)) == (None, 8)


def test_trials_that_were_discarded_come_back_to_their_places(tuning, qtbot):
    for text in ("20", "25"):
        tried(tuning, qtbot, text=text)
    table = tuning.features.tune.panel.table
    table.selectRow(1)
    table.setFocus()
    QTest.keyClick(table, Qt.Key.Key_Delete)
    first, second, third = (f"sigma joint {value} deg" for value in (20, 25, 30))
    assert names(tuning) == [second]
    assert named(tuning)[0] == f"Undo Discard trial {first}"
    trigger(tuning, "trial_dismiss_all")
    assert names(tuning) == []
    press()
    assert names(tuning) == [second]
    press()
    assert names(tuning) == [first, second]
    tried(tuning, qtbot, text="30")
    assert names(tuning) == [first, second, third]
    tuning.features.tune.panel.table.selectRow(1)
    trigger(tuning, "trial_use")
    assert (named(tuning)[0], sigma(tuning)) == (f"Undo Use settings of trial {first}", 20.0)
    press()
    assert sigma(tuning) == 30.0
    settle(tuning, qtbot)


def test_a_trial_that_was_made_the_run_is_one_no_longer_though_it_was_stored(tuning, qtbot):
    runs, trial = tuning.context.session.runs, tried(tuning, qtbot)
    project, first = tuning.context.session.project.project, runs.active
    as_trial = trial.name
    trigger(tuning, "trial_run")
    settle(tuning, qtbot)
    as_run = trial.name
    assert as_run.startswith("1: accurate, ")
    assert [one.name for one in kept_runs(project.runs)] == [as_run]
    trigger(tuning, "annotate-flag")
    for _ in range(2):
        press()
        assert named(tuning)[0] == f"Undo Make trial {as_trial} the active run"
        press()
        settle(tuning, qtbot)
        assert (runs.active, names(tuning), trial.kept) == (first, [as_trial], "")
        assert kept_runs(project.runs) == ()
        press(CTRL | SHIFT)
        assert named(tuning)[1].startswith("Redo Flag")
        press(CTRL | SHIFT)
        settle(tuning, qtbot)
        assert (runs.active, names(tuning), trial.kept) == (trial, [], as_run)
        assert [one.name for one in kept_runs(project.runs)] == [as_run]
    assert runs.entries == (first, trial)


def test_saving_a_preset_and_using_it_is_one_edit(still):
    parameters = still.features.tune.parameters
    typed(still, "sigma_joint", "25")
    trigger(still, "preset_save")
    dialog = still.findChild(NameDialog)
    QTest.keyClicks(dialog.name, "wide")
    QTest.keyClick(dialog.name, Qt.Key.Key_Return)
    assert parameters.preset_box.currentText() == "wide"
    assert named(still)[0] == "Undo Save preset wide"
    press()
    assert still.features.tune.presets.shelf.own == ()
    assert parameters.preset_box.currentText() == still.context.session.track.preset != "wide"
    assert (named(still)[0], sigma(still)) == ("Undo Set sigma_joint to 25", 25.0)
    press(CTRL | SHIFT)
    assert parameters.preset_box.currentText() == "wide"
    QTest.keyClick(parameters.preset_box, Qt.Key.Key_Home)
    parameters.preset_box.textActivated.emit("fast")
    assert named(still)[0] == "Undo Use preset fast"
    press()
    assert (parameters.preset_box.currentText(), sigma(still)) == ("wide", 25.0)


def test_runs_of_the_list_are_renamed_removed_and_put_back(still, qtbot, quick_run_file):
    runs, keeper = still.context.session.runs, still.features.track.keeper
    other = entry_of_run(read_run(quick_run_file), quick_run_file)
    other.name = "other"
    runs.add(other, active=False)
    first = runs.active
    keeper.rename(first, "with the coat")
    trigger(still, "remove_run")
    assert (runs.active, runs.entries) == (other, (other,))
    assert named(still)[0] == "Undo Remove run with the coat"
    still.context.docks.views.tiles["N"].camera.setFocus()
    press()
    assert (runs.active, runs.entries) == (first, (first, other))
    assert named(still)[0] == "Undo Rename run quick to with the coat"
    keeper.keep(first)  # the project keeps it meanwhile
    settle(still, qtbot)
    assert first.kept == "with the coat"
    press()
    settle(still, qtbot)
    assert (first.name, first.kept) == ("quick", "quick")
    assert [one.name for one in kept_runs(still.context.session.project.project.runs)] == ["quick"]
    press(CTRL | SHIFT)
    settle(still, qtbot)
    assert (first.name, first.kept) == ("with the coat", "with the coat")
    trigger(still, "remove_run")
    settle(still, qtbot)
    assert (runs.entries, named(still)[0]) == ((other,), "Undo Delete run with the coat")
    press()
    settle(still, qtbot)
    assert (runs.active, runs.entries, first.kept) == (first, (first, other), "with the coat")
    assert still.context.docks.is_seen("runs")


def test_the_annotator_and_the_initial_pose_are_undone(still):
    session = still.context.session
    pose, name = session.tracker.first_pose, session.project.annotator
    trigger(still, "first_pose_tpose")
    trigger(still, "annotator")
    dialog = next(one for one in still.findChildren(QInputDialog) if one.isVisible())
    line = dialog.findChild(QLineEdit)
    line.selectAll()
    QTest.keyClicks(line, "B. Miller")
    QTest.keyClick(line, Qt.Key.Key_Return)
    assert session.project.project.who == "B. Miller"
    assert named(still)[0] == "Undo Set annotator to B. Miller"
    still.context.docks.views.tiles["N"].camera.setFocus()
    press()
    assert session.project.annotator == name
    assert named(still)[0] == "Undo Set initial pose to T pose"
    press()
    assert session.tracker.first_pose == pose


def test_closing_the_recording_ends_what_no_project_stores(still, qtbot):
    folder = still.context.session.document.recording.folder
    clicked(still, 3)
    typed(still, "sigma_joint", "25")
    still.context.session.document.close()
    assert named(still) == ("Undo", "Redo")
    still.context.session.opening.open(folder)
    qtbot.waitUntil(lambda: still.context.session.project.project is not None)
    settle(still, qtbot)
    assert named(still) == ("Undo Place left elbow in N_right, frame 3", "Redo")
    assert sigma(still) == 25.0, "parameters are those of the window"
