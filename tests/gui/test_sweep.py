"""Sweeps in the window: asked for, computed by a process of their own, plotted, taken over."""

import csv
import os
from dataclasses import replace
from pathlib import Path

import pytest
from PySide6.QtCore import QPoint, QSettings, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from app.features.sweep import dialog as dialog_module
from app.features.sweep.dialog import SweepDialog, count_words, counted_jobs, measured_seconds
from app.features.sweep.form import SweepForm
from app.features.sweep.points import SweepPoints, hint_for
from app.features.sweep.results import SweepResults
from app.services.tasks.task import TaskList
from app.session import sweeping as sweeps_module
from app.session.sweeping import SweepNow, SweepPresenter
from app.widgets.forms.sweep_values import SweepValues
from stereotrack_core.errors import InputError
from stereotrack_core.experiments.sweep.points import SweepRequest
from stereotrack_core.experiments.sweep.store import SweepPlaces, SweepState, SweepStore
from stereotrack_core.locks import FileLock

pytestmark = pytest.mark.window

COLUMNS = ("recording", "data_points", "preset", "seed", "status", "forearms", "lost", "job")


@pytest.fixture
def table(tmp_path):
    """A table of twelve runs whose forearms are 10 deg at 300 points and 5 deg at 900."""
    path = tmp_path / "sweep.csv"
    rows = [
        ("r", points, preset, seed, "done", error + seed + (preset == "fast"), 1.0, "x")
        for points, error in ((300, 10.0), (600, 7.0), (900, 5.0))
        for preset in ("accurate", "fast")
        for seed in (0, 1)
    ]
    with path.open("w", newline="") as file:
        csv.writer(file).writerows([COLUMNS, *rows])
    return path


def click_in(plot, x, y):
    """Press and let go where a value is drawn."""
    view = plot._plot.viewport()
    where = view.mapFrom(plot, plot.place_of(x, y))
    QTest.mouseClick(view, Qt.MouseButton.LeftButton, pos=QPoint(where.x(), where.y()))
    return where


def test_values_are_added_by_keys_and_taken_away(shown, qtbot):
    names = (("views", "Views."), ("iterations", "Corrections per frame set."))
    values = shown(SweepValues(names, hint_for))
    line = values.chooser.lineEdit()
    qtbot.keyClicks(line, "iterations")
    qtbot.keyClick(line, Qt.Key.Key_Return)
    field = values.field("iterations")
    with qtbot.waitSignal(values.changed):
        qtbot.keyClicks(field, "2,3")
    assert values.varied() == (("iterations", "2,3"),)
    assert "1 to 50" in hint_for("iterations")
    values.add("views", "N")
    values.remove("iterations")
    assert values.varied() == (("views", "N"),)


def request_for(recording, tmp_path):
    return SweepRequest(
        recordings=(recording,), seeds="0,1", grid=("iterations=2,3",), frames="0:3",
        table=tmp_path / "a.csv", preset="fast", workers=2,
        changes=("max_correspondence_distance=0.2",),
    )  # fmt: skip


def test_fields_are_a_request_whose_jobs_are_counted(shown, tmp_path, small_recording):
    form = shown(SweepForm())
    with pytest.raises(InputError, match="no recording"):
        form.request()
    form.add_recording(small_recording)
    with pytest.raises(InputError, match="no file name"):
        form.request()
    form.show_base("fast", ["max_correspondence_distance=0.2"])
    form.points.values.add("iterations", "2,3")
    form.seeds.setText("0,1")
    form.frames.setText("0:3")
    form.table.setText(str(tmp_path / "a.csv"))
    form.processes.setValue(2)
    asked = request_for(small_recording, tmp_path)
    assert form.request() == asked
    form.address.setText("tcp://host:8786")
    form.cluster.setChecked(True)
    there = replace(asked, workers=None, scheduler="tcp://host:8786")
    assert form.request() == there
    assert not form.files["tls_ca"].isVisible()
    form.address.setText("tls://host:8786")
    for name, field in form.files.items():
        assert field.isVisible()
        QTest.keyClicks(field, f"{name}.pem")
    files = {name: Path(f"{name}.pem") for name in form.files}
    assert form.request() == replace(there, scheduler="tls://host:8786", **files)
    assert "--tls-ca tls_ca.pem" in " ".join(form.request().arguments())
    form.address.setText("tcp://host:8786")
    assert form.request() == there
    count = counted_jobs(asked)
    assert (count.jobs, count.points, count.there, count.frames) == (4, 2, 0, 12)
    words = count_words(count, cluster=False)
    assert words.startswith("4 runs (2 points). To track: 12 frames")
    assert "not known yet" in words


def test_lists_and_searches_are_asked_for_like_grids(shown, tmp_path, small_recording):
    points = shown(SweepPoints())
    points.way.setCurrentIndex(points.way.findData("list"))
    with pytest.raises(InputError, match="no list of points"):
        points.fields()
    listed = tmp_path / "points.csv"
    listed.write_text("iterations,views\n2,NS\n3,\n4,\n")
    points.file.setText(str(listed))
    request = replace(request_for(small_recording, tmp_path), grid=())
    count = counted_jobs(replace(request, **points.fields()))
    assert (count.points, count.jobs) == (3, 6)
    points.way.setCurrentIndex(points.way.findData("search"))
    with pytest.raises(InputError, match="no parameters to search"):
        points.fields()
    points.ranges.add("max_correspondence_distance", "0.1:0.5")
    points.trials.setValue(4)
    points.judge.setCurrentIndex(points.judge.findData("lost"))
    asked = {"search": ("max_correspondence_distance=0.1:0.5",), "trials": 4, "minimise": "lost"}
    assert points.fields() == asked
    count = counted_jobs(replace(request, **points.fields()))
    assert (count.points, count.jobs) == (4, 8)
    points.way.setCurrentIndex(0)
    assert points.fields() == {"grid": ()}


def test_points_and_fields_tell_their_runs(shown, qtbot, table, tmp_path):
    results = shown(SweepResults(), 900, 640)
    results.open_table(table)
    assert results.across.currentData() == "data_points"
    assert results.second.currentData() == "preset"
    assert "mean and standard deviation over seed" in results.averaged_label.text()
    results.second.setCurrentIndex(0)
    results.draw()
    QApplication.processEvents()
    with qtbot.waitSignal(results.plot.rows_chosen) as chosen:
        click_in(results.plot, 900, 6.0)
    assert len(chosen.args[0]) == 4, "the mean's mark stands for all its runs"
    assert "data points 900" in results.chosen_label.text()
    assert "forearms 6.0" in results.chosen_label.text()
    with qtbot.waitSignal(results.taken_over) as taken:
        qtbot.mouseClick(results.take_button, Qt.MouseButton.LeftButton)
    assert taken.args[0] == {"data_points": "900"}
    qtbot.mouseClick(results.best_button, Qt.MouseButton.LeftButton)
    assert "data points 900, preset accurate – 2 runs" in results.chosen_label.text()
    results.kind.setCurrentIndex(1)
    results.second.setCurrentIndex(results.second.findData("preset"))
    results.draw()
    QApplication.processEvents()
    with qtbot.waitSignal(results.plot.rows_chosen) as chosen:
        click_in(results.plot, 0, 1)
    assert chosen.args[0] == (2, 3)
    for name in ("heat.svg", "heat.png"):
        results.save_picture(tmp_path / name)
        assert (tmp_path / name).stat().st_size > 2000


def test_a_table_that_grows_is_read_again(shown, qtbot, table):
    results = shown(SweepResults(), 700, 500)
    results.open_table(table)
    results.measure.setCurrentIndex(results.measure.findData("lost"))
    with table.open("a", newline="") as file:
        csv.writer(file).writerow(("r", 1200, "fast", 0, "done", 4.0, 1.0, "y"))
    qtbot.waitUntil(lambda: "13 runs" in results.file_label.text(), timeout=5000)
    assert results.measure.currentData() == "lost"
    table.write_text("a,b\n")
    with pytest.raises(InputError, match="not a sweep table"):
        results.open_table(table)


def test_a_sweep_is_asked_for_and_computed_and_its_values_taken_over(
    opened, qtbot, tmp_path, monkeypatch
):
    w = opened
    monkeypatch.setattr(dialog_module, "measured_seconds", lambda request, cancelled: 700.0)
    w.context.actions.action("sweep").trigger()
    dialog = w.features.sweep.dialog
    qtbot.waitUntil(lambda: dialog.settled, timeout=20_000)
    form = dialog.form
    assert len(form.recordings()) == 1
    form.show_base("fast", ["search_arms=no", "data_points=200", "fit_shape=no"])
    form.points.values.add("iterations", "2")
    form.frames.setText("0:2")
    form.seeds.setText("0")
    form.table.setText(str(tmp_path / "window.csv"))
    form.processes.setValue(1)
    form.changed.emit()
    qtbot.waitUntil(lambda: dialog.settled and "1 run" in dialog.count_label.text(), timeout=20_000)
    form.points.values.field("iterations").setText("many")
    form.changed.emit()
    qtbot.waitUntil(lambda: "not a valid value" in dialog.error_label.text(), timeout=20_000)
    assert not dialog.accept_button.isEnabled()
    form.points.values.field("iterations").setText("2")
    form.changed.emit()
    qtbot.waitUntil(lambda: dialog.settled and dialog.accept_button.isEnabled(), timeout=20_000)
    assert dialog.measure_button.isVisible()
    qtbot.mouseClick(dialog.measure_button, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: "Estimated time: 12 min" in dialog.count_label.text(), timeout=120_000)
    qtbot.mouseClick(dialog.accept_button, Qt.MouseButton.LeftButton)
    assert w.features.sweep.presenter.now.going
    assert not dialog.accept_button.isEnabled()
    qtbot.waitUntil(lambda: not w.features.sweep.presenter.now.going, timeout=120_000)
    assert w.features.sweep.presenter.now.phase == "done", w.features.sweep.presenter.now.words
    assert "1 run computed" in dialog.words.text()
    qtbot.waitUntil(
        lambda: "all results are already in the table" in dialog.count_label.text(), timeout=20_000
    )
    qtbot.mouseClick(dialog.results_button, Qt.MouseButton.LeftButton)
    assert "1 run" in w.features.sweep.results.file_label.text()
    w.features.sweep.take_over({"preset": "fast", "iterations": "7", "views": "N"})
    assert w.context.session.track.settings.tracking.iterations == 7
    assert w.context.session.track.preset == "fast"
    w.features.sweep.take_over({"iterations": "many"})
    assert "not a valid value" in w.messages.message.sentence()
    w.messages.clear()
    assert w.statusBar().currentMessage().startswith("Applied")
    now = SweepNow("failed", 0.5, "No room on the disk.", tmp_path / "window.csv")
    w.features.sweep.presenter.changed.emit(now)
    assert "the sweep failed. No room" in w.messages.message.sentence()
    w.messages.clear()
    w.features.sweep.presenter.changed.emit(SweepNow("done", 1.0, "Done: 3 runs computed."))
    assert w.statusBar().currentMessage() == "Sweep: Done: 3 runs computed."


class Going:
    """What stands in for a sweep that another window has begun."""

    def __init__(self, path):
        self.store = SweepStore(SweepPlaces(path))
        self.tell(0.25)

    def tell(self, share, ended=""):
        self.store.note_state(
            SweepState(jobs=8, reused=1, computed=int(7 * share), share=share,
                       seconds_left=30.0, ended=ended)
        )  # fmt: skip


def test_a_sweep_that_goes_on_is_followed_by_the_next_window(shown, qtbot, tmp_path, monkeypatch):
    monkeypatch.setattr(sweeps_module, "_LOCK_LOOK_MS", 100)
    path = tmp_path / "sweep.csv"
    settings = QSettings(str(tmp_path / "s.ini"), QSettings.Format.IniFormat)
    settings.setValue("sweep/table", str(path))
    going = Going(path)
    presenter = SweepPresenter(settings)
    dialog = shown(SweepDialog(presenter, TaskList()), 980, 620)
    qtbot.waitUntil(lambda: "2 of 8 runs done, about 30 s left" in dialog.words.text())
    assert dialog.stop_button.isEnabled()
    qtbot.mouseClick(dialog.stop_button, Qt.MouseButton.LeftButton)
    assert going.store.stop_asked()
    assert "Stopping" in dialog.words.text()
    going.tell(0.5, "stopped")
    going.store.close()
    qtbot.waitUntil(lambda: presenter.now.phase == "stopped", timeout=5000)
    assert "Start resumes the sweep" in dialog.words.text()
    assert not dialog.progress.isVisible()
    qtbot.waitUntil(lambda: dialog.settled, timeout=20_000)
    presenter.leave()


def test_a_window_that_is_closed_stops_a_sweep_only_when_asked(qtbot, tmp_path):
    path = tmp_path / "sweep.csv"
    settings = QSettings(str(tmp_path / "s.ini"), QSettings.Format.IniFormat)
    settings.setValue("sweep/table", str(path))
    going = Going(path)
    presenter = SweepPresenter(settings)
    assert presenter.now.going
    presenter.leave()
    assert not going.store.stop_asked()
    presenter = SweepPresenter(settings)
    presenter.goes_on = False
    presenter.leave()
    assert going.store.stop_asked()
    going.store.close()
    assert not SweepPresenter(settings).now.going


def test_a_sweep_that_cannot_begin_says_why(qtbot, tmp_path):
    settings = QSettings(str(tmp_path / "s.ini"), QSettings.Format.IniFormat)
    presenter = SweepPresenter(settings)
    presenter.begin(["sweep", str(tmp_path / "none"), "-o", "a.csv"], tmp_path / "a.csv")
    qtbot.waitUntil(lambda: not presenter.now.going, timeout=60_000)
    assert presenter.now.phase == "failed"
    assert "none" in presenter.now.words
    assert "Traceback" not in presenter.now.words
    other = FileLock(tmp_path / "b.csv")
    presenter.begin(["sweep", str(tmp_path / "none"), "-o", "b.csv"], tmp_path / "b.csv")
    assert presenter.now.phase == "failed"
    assert f"being written by process {os.getpid()} on " in presenter.now.words
    other.release()


def test_a_sweep_can_be_stopped_at_once(qtbot, tmp_path, small_recording):
    settings = QSettings(str(tmp_path / "s.ini"), QSettings.Format.IniFormat)
    presenter = SweepPresenter(settings)
    table = tmp_path / "a.csv"
    presenter.begin(["sweep", str(small_recording), "-o", str(table)], table)
    presenter.stop()
    assert presenter.now.phase == "stopping"
    qtbot.waitUntil(lambda: not presenter.now.going, timeout=60_000)
    assert presenter.now.phase == "stopped"
    assert not SweepPlaces(table).journal.exists() or not table.exists()


@pytest.mark.slow
def test_the_time_of_a_sweep_is_measured_in_another_process(tmp_path, small_recording):
    request = request_for(small_recording, tmp_path)
    assert measured_seconds(request, lambda: False) > 0
    assert measured_seconds(request, lambda: True) is None
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(InputError, match="the run time could not be measured"):
        measured_seconds(request_for(tmp_path / "none", tmp_path), lambda: False)
