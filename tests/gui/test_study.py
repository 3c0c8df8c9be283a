"""Studies in the window: recordings, settings, tracking, results."""

import dataclasses
import math

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from app.features.study.pages import SettingsForm, baseline_of
from app.session import study as study_module
from app.session.changes import Part
from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.summary import evaluate
from stereotrack_core.study.description import StudySettings, read_study, write_study
from tests.gui.hands import trigger
from tests.gui.made_runs import add_run
from tests.study.conftest import InThisProcess, study, walks  # noqa: F401 - fixtures

pytestmark = pytest.mark.window


@pytest.fixture
def studies(window, qtbot, study, monkeypatch):  # noqa: F811
    """The window of a study that was read; runs are made without processes."""
    monkeypatch.setattr(study_module, "LocalWorkers", lambda _: InThisProcess())
    window.context.session.open(study.path)
    studies = window.context.session.study
    qtbot.waitUntil(lambda: studies.study is not None and not studies.working)
    return studies


@pytest.fixture
def sheet(studies, window):
    return window.features.study.window


def names(window):
    rows = range(window.proxy.rowCount())
    return [window.proxy.index(k, 0).data().removeprefix("data/") for k in rows]


def cell(window, recording, heading):
    """Index of a cell as the table shows it."""
    column = [one.heading for one in window.model.columns].index(heading)
    return window.proxy.index(names(window).index(recording), column)


def test_the_table_is_filtered_and_sorted_and_recordings_are_opened(studies, sheet, window, qtbot):
    shown = sheet
    assert names(shown) == ["anna/fast", "anna/slow", "ben/slow"]
    assert cell(shown, "ben/slow", "frames").data() == "6"
    header = shown.view.header()
    frames = cell(shown, "ben/slow", "frames").column()
    where = header.sectionViewportPosition(frames) + header.sectionSize(frames) // 2
    for order in (["anna/slow", "anna/fast", "ben/slow"], ["ben/slow", "anna/fast", "anna/slow"]):
        QTest.mouseClick(
            header.viewport(), Qt.MouseButton.LeftButton, pos=QPoint(where, header.height() // 2)
        )
        assert names(shown) == order
    qtbot.keyClicks(shown.filter, "ben")
    assert names(shown) == ["ben/slow"]
    assert shown.chosen() == ("data/ben/slow",), "all that are shown, if none is selected"
    shown.select(shown.chosen())
    assert shown.messages.text() == "No problems are known."
    opened = []
    window.context.session.changes.watch(Part.RECORDING_OPENED, lambda: opened.append(True))
    QTest.mouseClick(shown.open_button, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: bool(opened))
    folder = window.context.session.document.recording.folder
    assert folder == shown.study.place("data/ben/slow")
    qtbot.waitUntil(window.context.tasks.settled)


def test_recordings_are_removed_and_found_again(studies, sheet, qtbot):
    shown = sheet
    studies.remove(("data/anna/fast",))
    assert names(shown) == ["anna/slow", "ben/slow"]
    assert len(read_study(shown.study.path).rows) == 2
    studies.add((shown.study.place("data/anna"),))
    qtbot.waitUntil(lambda: not studies.working)
    assert "1 recording added" in shown.words.text()
    assert sorted(names(shown)) == ["anna/fast", "anna/slow", "ben/slow"]


def test_what_another_program_wrote_is_never_overwritten(studies, sheet, qtbot):
    shown = sheet
    other = dataclasses.replace(shown.study, rows=shown.study.rows[:1])
    write_study(other)
    studies.remove(("data/ben/slow",))
    assert "another program has changed" in shown.words.text()
    assert read_study(shown.study.path) == other
    studies.refresh()
    qtbot.waitUntil(lambda: not studies.working)
    assert names(shown) == ["anna/fast"]


def test_settings_are_tracked_plotted_and_applied(studies, sheet, window, qtbot):
    shown = sheet
    shown.tabs.setCurrentWidget(shown.form)
    shown.form.add("iterations", "many")
    assert "not a valid value" in shown.count.text()
    shown.form.field("iterations").setText("2,3")
    shown.form.frames.setText("0:2")
    shown.form.changed.emit()
    assert shown.count.text() == "6 runs: 2 points, 3 recordings, 1 seed."
    shown.select(["data/ben/slow"])
    QTest.mouseClick(shown.track_button, Qt.MouseButton.LeftButton)
    assert studies.working
    assert not shown.track_button.isEnabled()
    qtbot.waitUntil(lambda: not studies.working)
    assert read_study(shown.study.path).settings.grid == ("iterations=2,3",)
    assert cell(shown, "ben/slow", "runs").data() == "2 of 2"
    assert cell(shown, "anna/slow", "runs").data() == "0 of 2"
    results = shown.results
    assert results.path == shown.study.table
    assert results.across.currentData() == "iterations"
    shown.tabs.setCurrentWidget(results)
    QTest.mouseClick(results.best_button, Qt.MouseButton.LeftButton)
    best = results.table.common(results.table.best("forearms"))
    assert results.plot._lines == ("6", pytest.approx(math.nan, nan_ok=True)), "the value now"
    QTest.mouseClick(results.take_button, Qt.MouseButton.LeftButton)
    tracking = window.context.session.track.settings.tracking
    assert str(tracking.iterations) == best["iterations"]
    qtbot.waitUntil(lambda: results.plot._lines[0] == best["iterations"])


def test_a_sweep_is_a_study_of_the_open_recording(newly_opened, qtbot):
    w = newly_opened
    trigger(w, "sweep")
    qtbot.waitUntil(lambda: not w.context.session.study.working)
    shown = w.features.study.window
    assert shown.tabs.currentWidget() is shown.form
    (row,) = shown.study.rows
    assert shown.study.place(row.recording) == w.context.session.document.recording.folder.resolve()
    assert shown.study.settings.preset == w.context.session.track.preset
    assert math.isnan(baseline_of(w.context, "forearms"))
    entry = add_run(w, "made", off=0.1)
    settings = StudySettings(frames="2:6")
    w.context.session.study.edit(lambda one: dataclasses.replace(one, settings=settings))
    qtbot.waitUntil(w.context.tasks.settled)
    truth = w.context.session.document.recording.reference
    found = evaluate(entry.stored, truth, range(2, 6)).measure("forearms").statistics.mean
    assert baseline_of(w.context, "forearms") == pytest.approx(found)
    shown.study.path.unlink()
    shown.close()


def test_fields_say_the_settings(shown, qtbot):
    form = shown(SettingsForm(lambda: None), 900, 500)
    before = StudySettings(preset="fast", grid=("views=N,NS",), seeds="0,1", changes=("grid_x=1",))
    form.show_settings(dataclasses.replace(before, changes=("iterations=3",)))
    assert "fast with iterations 3" in form.base.text()
    assert form.field("views").text() == "N,NS"
    qtbot.keyClicks(form.chooser.lineEdit(), "data points")
    qtbot.keyClick(form.chooser.lineEdit(), Qt.Key.Key_Return)
    qtbot.keyClicks(form.field("data_points"), "100,200")
    form.seeds.setText("0, 2")
    found = form.settings()
    assert (found.grid, found.seeds) == (("views=N,NS", "data_points=100,200"), "0,2")
    form.seeds.setText("a")
    with pytest.raises(InputError, match="list of seeds"):
        form.settings()
