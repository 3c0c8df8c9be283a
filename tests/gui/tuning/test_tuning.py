"""What somebody who tunes does in the real window."""

import os
import signal
import sys
from contextlib import contextmanager

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QInputDialog

from stereotrack_core.experiments.run_process import load
from stereotrack_core.interop.run_file import read_run
from stereotrack_core.tracking.presets import preset, read_preset
from tests.gui.hands import trigger

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


def tried(window, qtbot, name="sigma_joint", text="25"):
    """A trial with one other value."""
    typed(window, name, text)
    qtbot.waitUntil(window.context.tasks.settled)
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
    qtbot.waitUntil(tuning.context.tasks.settled)
    (trial,) = tuning.features.tune.trials.entries
    assert tuning.context.session.runs.active is run
    assert (trial.name, trial.kind) == ("sigma joint 25 deg", "trial")
    assert sorted(trial.frames) == list(range(8)) == list(tuning.context.docks.timeline.selection)
    assert trial.settings.tracking.sigma_joint == 25.0
    assert trial.origin.spec.seed == read_run(quick_run_file).meta["seed"] == 2
    styles = {curve.name: curve.style for curve in tuning.features.review.plot.plot.shown_curves}
    assert styles[run.name] == "solid" != styles[trial.name]
    model = tuning.features.tune.panel.table.cells
    assert model.cell(1, 0).text.splitlines()[1] == "frames 0 – 7"
    assert [model.cell(k, 0).text.splitlines()[0] for k in range(2)] == ["quick", trial.name]
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
    qtbot.waitUntil(tuning.context.tasks.settled)
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
    qtbot.waitUntil(tuning.context.tasks.settled)
    assert names(tuning) == ["sigma joint 35 deg"]
    assert trials.entries[0].settings.tracking.sigma_joint == 35.0
    assert sorted(trials.entries[0].frames) == list(range(8))


def test_trials_stay_until_dismissed_one_or_all(tuning, qtbot):
    for text in ("20", "25", "30"):
        tried(tuning, qtbot, text=text)
    assert names(tuning) == [f"sigma joint {value} deg" for value in (20, 25, 30)]
    tuning.features.tune.panel.choose(2)
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
    for name, text in (("iterations", "2"), ("sigma_joint", "20")):
        typed(tuning, name, text)
        qtbot.waitUntil(lambda: not tuning.features.tune.trials.waits)
        qtbot.waitUntil(tuning.context.tasks.settled)
    assert names(tuning)[-1] == "sigma joint 20 deg, iterations 2", "what was changed last is first"


def test_differences_are_from_the_run(tuning, qtbot):
    tried(tuning, qtbot, text="20")
    model = tuning.features.tune.panel.table.cells
    run, trial = (model.cell(k, 1).text for k in range(2))
    assert "(" not in run
    value, change = trial.split(" ")
    assert float(value) - float(change.strip("()")) == pytest.approx(float(run), abs=0.11)


def drawn(window):
    """How the curves of each run are drawn: width, whether solid, and how opaque."""
    plot = window.features.review.plot.plot
    pens = {c.name: i.opts["pen"] for c, i in zip(plot._curves, plot._items, strict=True)}
    solid = Qt.PenStyle.SolidLine
    return {
        name: (pen.widthF(), pen.style() == solid, pen.color().alpha())
        for name, pen in pens.items()
    }


def test_a_trial_becomes_the_run(tuning, qtbot):
    trial = tried(tuning, qtbot)
    trigger(tuning, "trial_run")
    assert tuning.context.session.runs.active is trial
    assert trial.name.startswith("1: accurate, "), "a run is named by preset and differences"
    assert names(tuning) == []
    qtbot.waitUntil(tuning.context.tasks.settled)
    np.testing.assert_array_equal(trial.run().frame, np.arange(8))
    assert trial.run().meta["parameters"]["sigma_joint"] == 25.0


def test_a_trial_is_adopted_as_a_preset_of_the_project(tuning, qtbot, tmp_path):
    trial = tried(tuning, qtbot)
    typed(tuning, "sigma_joint", "40")
    tuning.features.tune.trials.cancel()
    tuning.features.tune.panel.choose(1)
    trigger(tuning, "trial_adopt")
    shelf = tuning.features.tune.presets
    shelf.keep("fast", trial.settings)
    assert "built-in preset" in tuning.messages.text()
    dialog = tuning.findChild(QInputDialog)
    dialog.setTextValue("wide joints")
    dialog.accept()
    assert shelf.own == ("wide joints",)
    assert shelf.settings("wide joints") == trial.settings == tuning.context.session.track.settings
    assert tuning.features.tune.parameters.preset_box.currentText() == "wide joints"
    assert tuning.context.session.track.settings == tuning.context.session.track.base
    path = tmp_path / "wide.toml"
    shelf.write_file(path)
    assert preset(str(path)) == trial.settings
    trigger(tuning, "preset_delete")
    assert shelf.own == ()
    shelf.take_file(path)
    assert shelf.own == ("wide joints",)
    assert read_preset(path).settings == tuning.context.session.track.settings
    trigger(tuning, "undo")
    assert shelf.own == ()
    qtbot.waitUntil(tuning.context.tasks.settled)


def test_differences_of_settings_are_from_preset_run_or_thesis(tuning, qtbot):
    tuning.features.tune.toggle_live()
    typed(tuning, "sigma_joint", "25")
    box = tuning.features.tune.parameters.against_box
    counts = {}
    for place in range(box.count()):
        box.setCurrentIndex(place)
        box.activated.emit(place)
        tuning.features.tune.parameters.search.clear()
        counts[box.currentData()] = tuning.features.tune.parameters.changed_words.text().split(
            " from"
        )[0]
    assert counts["run"] == "1 changed"
    assert len(set(counts.values())) == 3
    assert tuning.features.tune.parameters.line("sigma_joint").is_changed
    tuning.features.tune.toggle_live()
