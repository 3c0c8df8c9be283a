"""Failures in the window: found by themselves, listed, filtered, jumped to, looped."""

import csv
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from app.features.annotate.filling import retracking
from app.session.changes import Part
from app.session.remedies import Harm, Remedy, Tried
from stereotrack_core.evaluation.failure_segments.reasons import Reason
from stereotrack_core.study.description import Study, StudyRecording
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.tuning.remedy import Change
from tests.gui.hands import frames_shown, settle, trigger
from tests.gui.made_runs import add_run

pytestmark = pytest.mark.window

SHIFT = Qt.KeyboardModifier.ShiftModifier


@pytest.fixture
def reviewing(opened, qtbot):
    """The Review workspace with a run whose arms are lost in frames 1 to 3."""
    opened.context.docks.show_named("review")
    opened.context.docks.dock("failures").raise_()
    add_run(opened, "wild", off=0.05, wild=(1, 2, 3))
    settle(opened, qtbot)
    return opened


def rows(window):
    model = window.features.review.failures.panel.tree.sorted
    columns = range(model.columnCount())
    return [[model.index(row, k).data() for k in columns] for row in range(model.rowCount())]


def test_failures_of_the_active_run_are_listed_and_explained(reviewing):
    assert [row[0] for row in rows(reviewing)] == ["1–3"]
    assert rows(reviewing)[0][1] == "left arm, right arm"
    panel = reviewing.features.review.failures.panel
    model = panel.tree.sorted
    headings = [model.headerData(k, Qt.Orientation.Horizontal) for k in range(model.columnCount())]
    assert headings[2:4] == ["Error °", "Prob. %"]
    assert 80 < float(rows(reviewing)[0][2]) <= 180, "degrees, in a column of degrees"
    assert rows(reviewing)[0][3] == "44", "the probability, though it was found by error"
    assert "1 failure" in reviewing.features.review.failures.panel.words.text()
    lanes = {lane.name: lane for lane in reviewing.context.docks.timeline.lanes}
    assert [(span.first, span.last) for span in lanes["failures"].spans] == [(1, 3)]


def test_keys_go_to_the_worst_frame_and_a_loop_stays_in_the_failure(reviewing, qtbot):
    assert reviewing.context.session.document.frame == 0
    QTest.keyClick(reviewing, Qt.Key.Key_N, SHIFT)
    settle(reviewing, qtbot)
    assert reviewing.context.session.document.frame in (1, 2, 3)
    evidence = reviewing.features.review.failures.panel.evidence
    assert evidence.isVisible()
    assert "Frames 1 to 3" in evidence.toPlainText()

    seen = frames_shown(reviewing)
    QTest.keyClick(reviewing, Qt.Key.Key_Space, SHIFT)
    assert reviewing.context.session.document.loop == range(7)
    qtbot.waitUntil(lambda: 6 in seen and 0 in seen[seen.index(6) :])
    assert max(seen) == 6
    QTest.keyClick(reviewing, Qt.Key.Key_Space, SHIFT)
    assert reviewing.context.session.document.loop is None
    assert not reviewing.context.session.document.playing
    settle(reviewing, qtbot)


def test_enter_jumps_and_filters_list_others(reviewing, qtbot):
    panel = reviewing.features.review.failures.panel
    reviewing.context.session.document.go_to(7)
    panel.tree.setFocus()
    panel.tree.setCurrentIndex(panel.tree.sorted.index(0, 0))
    QTest.keyClick(panel.tree, Qt.Key.Key_Return)
    assert reviewing.context.session.document.frame in (1, 2, 3)
    assert "unavailable" not in reviewing.statusBar().currentMessage(), "the key was of use"
    told = replace(panel.tree.cells.rows[0], reason=Reason("right", "", "The arms are near."))
    assert panel.tree.cells._cells_of(told)[-1].text == "correct", "right could be a side"
    panel.evidence.show_words("", told)
    assert f"In frame {told.first}: The arms" in panel.evidence.toPlainText(), "not in its worst"
    panel.filter.setText("head")
    settle(reviewing, qtbot)
    assert rows(reviewing) == []
    assert reviewing.context.session.failures.chosen is None
    assert reviewing.context.session.failures.none_listed() == "No failure is listed."
    panel.filter.setText("Left error")
    settle(reviewing, qtbot)
    assert len(rows(reviewing)) == 1
    settle(reviewing, qtbot)


def test_a_link_of_the_evidence_shows_the_parameter_in_tune(reviewing, qtbot):
    panel = reviewing.features.review.failures.panel
    panel.tree.setCurrentIndex(panel.tree.sorted.index(0, 0))
    settle(reviewing, qtbot)
    view = panel.evidence.viewport()
    places = (QPoint(x, y) for y in range(0, view.height(), 4) for x in range(0, view.width(), 8))
    there = next(place for place in places if panel.evidence.anchorAt(place))
    name = panel.evidence.anchorAt(there)
    QTest.mouseClick(view, Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier, there)
    settle(reviewing, qtbot)
    assert reviewing.context.docks.workspace == "tune"
    parameters = reviewing.features.tune.parameters
    assert parameters.search.text() == name
    assert not parameters.search.visibleRegion().isEmpty()


def test_the_list_has_a_context_menu_and_is_saved_as_a_table(reviewing, tmp_path):
    panel, remedies = reviewing.features.review.failures.panel, reviewing.features.review.remedies
    offered = [action.text().replace("&", "") for action in panel.tree.actions()]
    for words in ("Loop failure", "Find what fixes this", "Find out why failures begin"):
        assert words in offered
    assert offered[-1].startswith("Export failures")
    path = tmp_path / "failures.csv"
    remedies.export(path)
    (cells,) = csv.DictReader(path.read_text().splitlines())
    assert (cells["frames"], cells["detected by"]) == ("1-3", "truth")
    assert float(cells["error [deg]"]) > 80.0


def test_the_table_of_remedies_says_in_which_recording_of_the_study_they_harm(reviewing, qtbot):
    session, panel = reviewing.context.session, reviewing.features.review.remedies.panel
    run, (failure,) = session.runs.active, session.failures.listed
    reviewing.context.docks.bring_up("remedies")
    study = Study(
        Path("walks.study.toml"), (StudyRecording("data/slow"), StudyRecording("data/fast"))
    )
    harms = Harm("data/slow", 0.2, " %"), Harm("data/fast", 4.25, "°")
    remedy = Remedy(Change("iterations 2", preset("fast")), run, 12.0, 40.0, 0.0, harms)
    unchecked = replace(remedy, change=Change("more", preset("fast")), gain=30.0, elsewhere=())
    alone = Tried("remedy", run, failure, range(7), "°", 52.0, 2, 3, remedies=(remedy, unchecked))
    shown = []
    for tried in (alone, replace(alone, study=study, others=study.rows)):
        session.remedies.tried = tried
        session.changes.tell(Part.REMEDIES)
        settle(reviewing, qtbot)
        table = panel.table.cells
        columns = range(table.columnCount())
        shown.append([[table.cell(row, k).text for k in columns] for row in range(2)])
    assert shown[0] == [["iterations 2", "12.0", "+40.0", "0.0"], ["more", "12.0", "+30.0", "0.0"]]
    assert [row[4:] for row in shown[1]] == [["4.2°", "fast"], ["", ""]]
    tip = table.cell(0, 4).tip
    assert "data/slow: 0.2 %" in tip
    assert "data/fast: 4.2°" in tip
    assert "Study walks: 2 of 2 other recordings checked." in panel.words.text()


def test_what_is_only_flagged_is_told_beside_the_threshold(reviewing, qtbot):
    failures, entry = reviewing.context.session.failures, reviewing.context.session.runs.active
    reviewing.features.review.failures.panel.filter.clear()
    found = failures.found
    (one,) = found.failures
    flagged = replace(one, found="signs", measure="chance", peak=0.6, error_deg=40.2, chance=0.6)
    failures._known[entry] = replace(found, failures=(flagged,))
    failures._tell()
    settle(reviewing, qtbot)
    panel = reviewing.features.review.failures.panel
    said = "1 stretch flagged; largest error 40°, below your threshold of 45°."
    assert panel.words.text().startswith(said)
    assert rows(reviewing)[0][2:4] == ["40", "60"]


def test_another_threshold_and_another_run_find_others(reviewing, qtbot):
    reviewing.context.view_state.set_threshold(180.0)
    settle(reviewing, qtbot)
    assert rows(reviewing) == []
    assert "No failure" in reviewing.features.review.failures.panel.words.text()
    reviewing.context.view_state.set_threshold(45.0)
    settle(reviewing, qtbot)
    assert len(rows(reviewing)) == 1
    add_run(reviewing, "good", off=0.05)
    settle(reviewing, qtbot)
    assert rows(reviewing) == []
    assert "failures" not in [lane.name for lane in reviewing.context.docks.timeline.lanes]


def test_a_click_in_the_film_strip_corrects_a_point_and_the_strip_shows_the_new_run(
    reviewing, qtbot
):
    window, strip = reviewing, reviewing.features.review.strip
    window.context.docks.bring_up("strip")
    failures = window.context.session.failures
    failures.choose(failures.listed[0])
    settle(window, qtbot)
    qtbot.waitUntil(lambda: bool(strip.view._cells))
    assert strip.landmark.currentData() == "right_hand", "the outermost"
    assert "wild" in strip.words.text()
    trigger(window, "strip_blink")
    assert "reference" in strip.words.text()
    cell = strip.view._cells[-1]
    place = strip.view.area_of(cell).center()
    QTest.mouseClick(strip.view, Qt.MouseButton.LeftButton, pos=place.toPoint())
    assert window.context.session.document.frame == cell.frame
    (click,) = window.context.session.project.project.clicks.at(cell.frame)
    assert (click.camera, click.landmark) == (cell.camera, "right_hand")
    assert click.position == pytest.approx(cell.pixel_at(0.5, 0.5), abs=3.0)
    qtbot.waitUntil(lambda: (cell.camera, cell.frame) in strip.view._marks)
    qtbot.waitUntil(lambda: not strip._soon.isActive())
    said = window.statusBar().currentMessage()
    assert said == window.context.actions.action("annotate-retrack").statusTip(), "why it is not"
    add_run(window, "corrected", off=0.05)
    settle(window, qtbot)
    trigger(window, "strip_blink")
    qtbot.waitUntil(lambda: len(strip._layers) == 3)
    assert strip._layers[:2] == ("corrected", "wild")
    assert len(strip.view._cells[0].pictures) == 3
    settle(window, qtbot)


@pytest.fixture
def strip(reviewing, qtbot, monkeypatch):
    """The film strip with the failure, and the active run in it."""
    monkeypatch.setattr(reviewing.features.review.strip, "_layer", 0)
    reviewing.context.docks.bring_up("strip")
    failures = reviewing.context.session.failures
    failures.choose(failures.listed[0])
    settle(reviewing, qtbot)
    qtbot.waitUntil(lambda: bool(reviewing.features.review.strip.view._cells))
    return reviewing.features.review.strip


def test_a_click_in_the_film_strip_tracks_again_around_it(reviewing, strip, qtbot, monkeypatch):
    again, own = [], reviewing.features.annotate.retracking
    found = SimpleNamespace(into=lambda run, _frames: run)
    monkeypatch.setattr(retracking, "_why_not_with_clicks", lambda _entry: "")
    monkeypatch.setattr(retracking, "in_process", lambda *_: found)
    monkeypatch.setattr(own, "_task_of", lambda *_: None)
    monkeypatch.setattr(own, "_take", lambda _entry, stretch, *_: again.append(stretch))
    cell = next(one for one in strip.view._cells if one.frame == 2)
    place = strip.view.area_of(cell).center().toPoint()
    QTest.mouseClick(strip.view, Qt.MouseButton.LeftButton, pos=place)
    assert not again, "until a person has clicked all that is wrong"
    qtbot.waitUntil(lambda: bool(again))
    assert set(range(1, 4)) <= set(again[0]), "the failure, and frames beside it"
    settle(reviewing, qtbot)
    assert len(again) == 1


def test_two_runs_blink_in_the_film_strip(reviewing, strip, qtbot):
    add_run(reviewing, "other", off=0.02, wild=(1, 2))
    settle(reviewing, qtbot)
    for name in ("wild", "other", "wild"):
        QTest.keyClick(reviewing, Qt.Key.Key_T, SHIFT)
        settle(reviewing, qtbot)
        qtbot.waitUntil(lambda name=name: strip._layers[:1] == (name,))
        assert reviewing.context.session.runs.active.name == name
        assert f": {name}" in strip.words.text()
