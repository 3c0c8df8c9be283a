"""What somebody who tunes does in the real window."""

import os
import signal
import sys
import threading
from contextlib import contextmanager

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from app.features.tune.presets import NameDialog
from app.session import judgement
from stereotrack_core.experiments.run_process import load
from stereotrack_core.interop.run_file import read_run
from stereotrack_core.tracking.presets import preset, read_preset

pytestmark = pytest.mark.window
unix = pytest.mark.skipif(sys.platform == "win32", reason="there are no such signals")


def typed(window, name, text):
    """Give a parameter a value by real keys, as a person finds it by the search."""
    window.features.tune.parameters.search.setFocus()
    window.features.tune.parameters.search.selectAll()
    QTest.keyClicks(window.features.tune.parameters.search, name.replace("_", " "))
    field = window.features.tune.parameters.line(name).editor
    assert field.isVisible()
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, text)
    QTest.keyClick(field, Qt.Key.Key_Return)


def trigger(window, name):
    window.context.actions.refresh()
    action = window.context.actions.action(name)
    assert action.isEnabled(), action.statusTip()
    action.trigger()


def tried(window, qtbot, name="sigma_joint", text="25"):
    """A trial with one other value."""
    typed(window, name, text)
    qtbot.waitUntil(window.context.tasks.settled, timeout=60_000)
    return window.features.tune.trials.entries[-1]


@contextmanager
def standing_still(window):
    """The process that tracks trials goes no further meanwhile."""
    process = window.context.session.processes.trials
    process(load)  # it may not have been started
    os.kill(process.pid, signal.SIGSTOP)
    try:
        yield
    finally:
        os.kill(process.pid, signal.SIGCONT)


def names(window):
    return [entry.name for entry in window.features.tune.trials.entries]


def test_an_edit_by_keys_leads_to_a_trial_beside_the_run(tuning, qtbot, quick_run_file):
    run = tuning.context.session.runs.active
    typed(tuning, "sigma_joint", "25")
    assert tuning.features.tune.trials.waits, "a moment passes before the tracker starts"
    assert "tracking" in tuning.features.tune.panel.words.text()
    qtbot.waitUntil(tuning.context.tasks.settled, timeout=60_000)
    (trial,) = tuning.features.tune.trials.entries
    assert tuning.context.session.runs.active is run
    assert (trial.name, trial.kind) == ("sigma joint 25 deg", "trial")
    assert sorted(trial.frames) == list(range(8)) == list(tuning.context.docks.timeline.selection)
    assert trial.settings.tracking.sigma_joint == 25.0
    assert trial.origin.spec.seed == read_run(quick_run_file).meta["seed"] == 2
    styles = {curve.name: curve.style for curve in tuning.features.review.plot.plot.shown_curves}
    assert styles[run.name] == "solid" != styles[trial.name]
    model = tuning.features.tune.panel.model
    assert model.cell(1, 0).text.splitlines()[1] == "frames 0 – 7"
    assert [model.cell(k, 0).text.splitlines()[0] for k in range(2)] == ["◆ quick", trial.name]
    assert "(" in model.cell(1, 1).text, "the difference from the run is stated"
    said = "The trial “sigma joint 25 deg” already has these settings."
    assert tuning.features.tune.panel.words.text() == said
    assert len(tuning.context.session.instant.told.ghosts) == 1, "it is drawn in the views as well"
    limits = tuning.features.tune.panel.limits
    assert limits.isVisible()
    assert limits.text().endswith("The run was read from a file, which rounds poses.")


def test_the_same_settings_are_not_tried_twice_and_the_run_s_own_not_at_all(tuning, qtbot):
    before = tuning.context.session.track.settings
    tried(tuning, qtbot)
    trigger(tuning, "trial_now")
    assert names(tuning) == ["sigma joint 25 deg"]
    typed(tuning, "sigma_joint", f"{before.tracking.sigma_joint:g}")
    qtbot.waitUntil(tuning.context.tasks.settled, timeout=60_000)
    assert names(tuning) == ["sigma joint 25 deg"]
    assert "settings of the run" in tuning.features.tune.panel.words.text()


@unix
def test_a_further_edit_ends_the_trial_in_progress(tuning, qtbot):
    trials = tuning.features.tune.trials
    with standing_still(tuning):
        for text in ("25", "30", "35"):
            typed(tuning, "sigma_joint", text)
            assert trials.running is None
            qtbot.waitUntil(lambda: trials.running is not None)
    qtbot.waitUntil(tuning.context.tasks.settled, timeout=60_000)
    assert names(tuning) == ["sigma joint 35 deg"]
    assert trials.entries[0].settings.tracking.sigma_joint == 35.0
    assert sorted(trials.entries[0].frames) == list(range(8))


@unix
def test_a_trial_takes_the_place_of_a_series(tuning, qtbot):
    series, trials = tuning.features.tune.series, tuning.features.tune.trials
    settings = tuning.context.session.track.settings
    row = next(one for one in settings.rows() if one.name == "sigma_joint")
    with standing_still(tuning):
        series.begin(row, (10.0, 15.0, 20.0), settings)
        typed(tuning, "sigma_joint", "25")
        qtbot.waitUntil(lambda: trials.running is not None)
        assert not series.running
    qtbot.waitUntil(tuning.context.tasks.settled)
    assert series.tried == (), "only values with frames stay"
    (trial,) = trials.entries
    assert len(trial.frames) == 8


def test_trials_stay_until_dismissed_one_or_all(tuning, qtbot):
    for text in ("20", "25", "30"):
        tried(tuning, qtbot, text=text)
    assert names(tuning) == [f"sigma joint {value} deg" for value in (20, 25, 30)]
    tuning.features.tune.panel.table.selectRow(2)
    tuning.features.tune.panel.table.setFocus()
    trigger(tuning, "trial_dismiss")
    assert names(tuning) == ["sigma joint 20 deg", "sigma joint 30 deg"]
    qtbot.waitUntil(tuning.context.tasks.settled)
    assert {c.name for c in tuning.features.review.plot.plot.shown_curves} == {
        "quick",
        "sigma joint 20 deg",
        "sigma joint 30 deg",
    }
    trigger(tuning, "trial_dismiss_all")
    assert names(tuning) == []
    qtbot.waitUntil(tuning.context.tasks.settled)
    assert {c.name for c in tuning.features.review.plot.plot.shown_curves} == {"quick"}


def test_differences_are_from_the_run_or_from_any_trial(tuning, qtbot):
    for text in ("20", "30"):
        tried(tuning, qtbot, text=text)
    table, model = tuning.features.tune.panel.table, tuning.features.tune.panel.model
    from_run = [model.cell(k, 1).text for k in range(3)]
    table.selectRow(1)
    trigger(tuning, "trial_compare")
    from_first = [model.cell(k, 1).text for k in range(3)]
    assert model.cell(1, 0).text.startswith("◆ sigma joint 20 deg")
    assert "(" not in from_first[1]
    value, change = from_first[0].split(" ")
    assert float(from_run[1].split(" ")[0]) + float(change.strip("()")) == pytest.approx(
        float(value), abs=0.11
    )


def test_a_run_is_named_by_its_preset_and_by_what_differs_from_it(opened):
    track, fast = opened.context.session.track, preset("fast")
    track.choose("fast", fast)
    assert track.name_of(fast) == "fast"
    other = fast.replaced(iterations=2, fit_shape=False)
    assert track.name_of(other) == "fast, iterations 2, fit shape no"
    runs = opened.context.session.runs
    assert runs.next_name(track.name_of(other)) == "1: fast, iterations 2, fit shape no"
    assert runs.free_name("iterations 2") == "iterations 2"


def drawn(window):
    """How the curves of each run are drawn: width, whether solid, and how opaque."""
    plot = window.features.review.plot.plot
    pens = {c.name: i.opts["pen"] for c, i in zip(plot._curves, plot._items, strict=True)}
    solid = Qt.PenStyle.SolidLine
    return {
        name: (pen.widthF(), pen.style() == solid, pen.color().alpha())
        for name, pen in pens.items()
    }


def test_the_chosen_trial_is_drawn_solid_and_thick_before_the_others(tuning, qtbot):
    for text in ("20", "30"):
        tried(tuning, qtbot, text=text)
    first, second = names(tuning)
    looks = drawn(tuning)
    assert looks[second] == (2.5, True, 255), "the newest"
    assert looks["quick"] == (1.0, True, 120)
    assert looks[first][0] == 1.0
    table = tuning.features.tune.panel.table
    place = table.visualRect(table.model().index(1, 0)).center()
    QTest.mouseClick(table.viewport(), Qt.MouseButton.LeftButton, pos=place)
    qtbot.waitUntil(tuning.context.tasks.settled)
    looks = drawn(tuning)
    assert looks[first] == (2.5, True, 255)
    assert looks[second][0] == looks["quick"][0] == 1.0
    assert "Green is lower" in tuning.features.tune.panel._colours.text()
    assert tuning.features.tune.panel._colours.isVisible(), "colours are explained where they are"


def test_the_scene_is_seen_beside_the_parameters(tuning):
    docks = tuning.context.docks
    assert all(docks.is_seen(name) for name in ("scene", "parameters", "trials", "plot"))
    assert docks.scene.is_seen()


def test_parameters_open_at_the_last_one_touched(tuning, qtbot):
    panel = tuning.features.tune.parameters
    tried(tuning, qtbot)
    assert tuning.context.settings.value("tune/parameter") == "sigma_joint"
    line, port = panel.line("sigma_joint"), panel._scroll.viewport()

    def top():
        return line.mapTo(port, QPoint(0, 0)).y()

    panel.search.setFocus()
    panel.search.selectAll()
    QTest.keyClick(panel.search, Qt.Key.Key_Delete)
    qtbot.waitUntil(lambda: 0 <= top() < 20)


def test_a_trial_becomes_the_run(tuning, qtbot):
    trial = tried(tuning, qtbot)
    trigger(tuning, "trial_run")
    assert tuning.context.session.runs.active is trial
    assert trial.name.startswith("1: accurate, "), "a run is named by preset and differences"
    assert names(tuning) == []
    qtbot.waitUntil(tuning.context.tasks.settled, timeout=60_000)
    np.testing.assert_array_equal(trial.run().frame, np.arange(8))
    assert trial.run().meta["parameters"]["sigma_joint"] == 25.0


def test_a_trial_is_adopted_as_a_preset_of_the_project(tuning, qtbot, tmp_path):
    trial = tried(tuning, qtbot)
    typed(tuning, "sigma_joint", "40")
    tuning.features.tune.trials.cancel()
    tuning.features.tune.panel.table.selectRow(1)
    trigger(tuning, "trial_adopt")
    dialog = tuning.findChild(NameDialog)
    save = dialog.buttons.button(dialog.buttons.StandardButton.Save)
    assert not save.isEnabled(), "a preset needs a name"
    QTest.keyClicks(dialog.name, "fast")
    assert "built-in preset" in dialog.remark.text()
    dialog.name.selectAll()
    QTest.keyClicks(dialog.name, "wide joints")
    QTest.mouseClick(save, Qt.MouseButton.LeftButton)
    shelf = tuning.features.tune.presets.shelf
    assert shelf.own == ("wide joints",)
    assert shelf.settings("wide joints") == trial.settings == tuning.context.session.track.settings
    assert tuning.features.tune.parameters.preset_box.currentText() == "wide joints"
    assert not tuning.context.session.track.differs_from_preset
    path = tmp_path / "wide.toml"
    tuning.features.tune.presets.write_file(path)
    assert preset(str(path)) == trial.settings
    trigger(tuning, "preset_delete")
    assert shelf.own == ()
    tuning.features.tune.presets.take_file(path)
    assert shelf.own == ("wide joints",)
    assert read_preset(path).settings == tuning.context.session.track.settings
    trigger(tuning, "undo")
    assert shelf.own == ()
    qtbot.waitUntil(tuning.context.tasks.settled, timeout=60_000)


def test_undo_after_a_change_leaves_a_run_that_was_kept(tuning, qtbot):
    tuning.features.track.with_active(tuning.features.track.keeper.keep)
    qtbot.waitUntil(tuning.context.tasks.settled, timeout=60_000)
    run = tuning.context.session.runs.active
    assert run.kept == "quick"
    before = tuning.context.session.track.settings
    typed(tuning, "sigma_joint", "25")
    tuning.context.actions.refresh()
    undo = tuning.context.actions.action("undo")
    assert undo.text() == "Undo Set sigma_joint to 25"
    undo.trigger()
    assert not undo.isEnabled()
    tuning.context.session.edits.undo()
    assert run in tuning.context.session.runs.entries
    assert tuning.context.session.project.project.runs.names() == ("quick",)
    assert tuning.context.session.track.settings == before
    tuning.features.track.with_active(tuning.features.track.keeper.remove)
    assert run not in tuning.context.session.runs.entries
    tuning.context.actions.refresh()
    assert undo.text() == "Undo Delete run quick"
    undo.trigger()
    qtbot.waitUntil(tuning.context.tasks.settled, timeout=60_000)
    assert tuning.context.session.project.project.runs.names() == ("quick",)
    assert [entry.name for entry in tuning.context.session.runs.entries if entry.kept] == ["quick"]


def test_differences_of_settings_are_from_preset_run_or_thesis(tuning, qtbot):
    tuning.features.tune.toggle_live()
    typed(tuning, "sigma_joint", "25")
    box = tuning.features.tune.parameters.against_box
    counts = {}
    for place in range(box.count()):
        box.setCurrentIndex(place)
        box.activated.emit(place)
        tuning.features.tune.parameters.search.clear()
        counts[box.currentData()] = tuning.features.tune.parameters.only_changed.text()
    assert counts["run"] == "1 changed"
    assert len(set(counts.values())) == 3
    assert tuning.features.tune.parameters.line("sigma_joint").is_changed
    tuning.features.tune.toggle_live()


def test_the_table_is_written_again_only_when_it_says_something_else(tuning, monkeypatch):
    tune, written = tuning.features.tune, []
    monkeypatch.setattr(tune.panel, "show_table", lambda *what: written.append(what))
    tune.trials.grew.emit()
    tuning.context.session.document.frame_changed.emit(0)
    assert not written
    tune.trials.changed.emit()
    assert written


def test_values_of_one_parameter_beside_each_other(tuning, qtbot, monkeypatch):
    panel, series = tuning.features.tune.series_panel, tuning.features.tune.series
    threads, judge = set(), judgement.judged

    def watched(*what):
        threads.add(threading.current_thread())
        return judge(*what)

    monkeypatch.setattr(judgement, "judged", watched)
    tuning.context.docks.dock("series").raise_()
    panel.choose("sampling")
    assert panel.low.isHidden()
    assert panel.unit.text().startswith("each of: ")
    panel.choose("sigma_joint")
    assert not panel.low.isHidden()
    panel.low.setText("5")
    panel.high.setText("500")
    QTest.mouseClick(panel.begin, Qt.MouseButton.LeftButton)
    assert not series.running
    assert "from 0.1 to 180 deg" in panel.words.text()
    panel.high.setText("45")
    panel.count.setValue(3)
    panel.by_factors.setChecked(True)
    QTest.mouseClick(panel.begin, Qt.MouseButton.LeftButton)
    assert series.running
    qtbot.waitUntil(tuning.context.tasks.settled, timeout=90_000)
    assert [one.value for one in series.tried] == [5.0, 15.0, 45.0]
    assert all(one.complete for one in series.tried)
    best = series.best()
    means = [one.summary.arms for one in series.tried]
    assert best == int(np.argmin(means))
    assert threads, "values are judged where runs are"
    assert threading.main_thread() not in threads
    assert [one.best for one in series.values()].count(True) == 1
    run = tuning.context.session.runs.active
    panel.slider.setFocus()
    QTest.keyClick(panel.slider, Qt.Key.Key_Right)
    assert series.shown == 1
    assert tuning.context.session.runs.active is run
    assert series.tried[1].entry in tuning.context.session.runs.entries
    place = panel.plot.place_of(45.0, means[2])
    view = panel.plot._plot.viewport()
    QTest.mouseClick(view, Qt.MouseButton.LeftButton, pos=view.mapFrom(panel.plot, place))
    assert series.shown == 2
    assert series.tried[1].entry not in tuning.context.session.runs.entries
    tuning.features.tune.trials.live = False
    QTest.mouseClick(panel.take, Qt.MouseButton.LeftButton)
    assert tuning.context.session.track.settings.tracking.sigma_joint == 45.0
    assert series.tried[2].entry not in tuning.context.session.runs.entries
    qtbot.waitUntil(tuning.context.tasks.settled, timeout=60_000)


def test_closing_while_trying_ends_the_threads(tuning, qtbot):
    typed(tuning, "sigma_joint", "25")
    qtbot.waitUntil(lambda: tuning.features.tune.trials.running is not None, timeout=10_000)
    tuning.close()
    assert tuning.features.tune.settled()
