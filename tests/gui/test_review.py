"""The Review workspace: statistics follow runs and selection."""

from __future__ import annotations

import csv
from io import StringIO

import pytest
from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QGuiApplication

from tests.gui.made_runs import add_run

pytestmark = pytest.mark.window

LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def reviewing(opened, qtbot):
    """The Review workspace with two runs: one good, one wild in frames 5 and 6."""
    add_run(opened, "wild", off=0.1, wild=(5, 6))
    add_run(opened, "good", off=0.05)
    opened.context.docks.show_named("review")
    qtbot.waitUntil(opened.context.tasks.settled, timeout=60_000)
    return opened


def show(window, qtbot, name):
    window.context.docks.dock(name).raise_()
    window.context.docks.dock(name).show()
    qtbot.waitUntil(window.context.docks.dock(name).widget().isVisible, timeout=5_000)
    settle(window, qtbot)


def settle(window, qtbot):
    window.features.review.panels.show_soon()
    qtbot.waitUntil(window.context.tasks.settled, timeout=60_000)


def select(window, qtbot, frames):
    window.context.docks.timeline.set_selection(frames)
    window.context.docks.timeline.selection_changed.emit(frames)
    settle(window, qtbot)


def tree_rows(panel):
    heads = [panel.tree.topLevelItem(i) for i in range(panel.tree.topLevelItemCount())]
    return {head.text(0): [head.text(i) for i in range(1, 7)] for head in heads}


def test_statistics_are_of_the_selection_obey_the_threshold_and_are_saved(
    reviewing, qtbot, tmp_path
):
    show(reviewing, qtbot, "statistics")
    panel = reviewing.features.review.panels.statistics
    rows = tree_rows(panel)
    assert list(rows)[:2] == ["whole recording", "wild, whole recording"]
    assert rows["wild, whole recording"][5] != "0.0"  # lost in two frames of eight
    assert rows["whole recording"][5] == "0.0"
    assert "of good against the recording's reference" in panel.words.text()
    select(reviewing, qtbot, range(4))
    assert tree_rows(panel)["wild, selection"][5] == "0.0"
    assert "frames 0 – 3" in panel.words.text()
    reviewing.context.actions.action("threshold_down").trigger()
    settle(reviewing, qtbot)
    assert panel.tree.headerItem().text(5) == "> 40°"
    reviewing.context.view_state.set_threshold(1.0)
    settle(reviewing, qtbot)
    assert tree_rows(panel)["selection"][4] == "100.0"
    select(reviewing, qtbot, None)
    reviewing.context.actions.action("copy_statistics").trigger()
    text = QGuiApplication.clipboard().text()
    rows = list(csv.DictReader(StringIO(text)))
    assert {row["run"] for row in rows} == {"good", "wild"}
    torso = next(r for r in rows if r["limb"] == "torso" and r["run"] == "good")
    assert (torso["stretch"], torso["frames"], torso["lost_percent"]) == (
        "whole recording",
        "8",
        "",
    )
    reviewing.features.review.panels.save_statistics(tmp_path / "numbers.csv")
    assert (tmp_path / "numbers.csv").read_text() == text
    reviewing.features.review.panels.save_statistics(tmp_path / "nowhere" / "numbers.csv")
    assert reviewing.messages.message is not None  # in words, not as a traceback


def test_without_truth_the_trackers_own_signs_are_shown_and_it_is_said(reviewing, qtbot):
    recording = reviewing.context.session.document.recording
    reviewing.context.view_state.set_threshold(12.0)
    object.__setattr__(recording, "reference", None)  # as if it had none
    reviewing.context.session.judging.judge()
    settle(reviewing, qtbot)
    assert reviewing.features.review.plot.plot.heading != "angular error"
    assert reviewing.features.review.plot.plot.threshold == 12.0
    show(reviewing, qtbot, "statistics")
    assert "No reference" in reviewing.features.review.panels.statistics.words.text()


def test_a_dragged_threshold_is_obeyed_by_next_and_previous(reviewing, qtbot):
    show(reviewing, qtbot, "statistics")
    plot = reviewing.features.review.plot.plot
    reviewing.context.docks.dock("plot").raise_()
    settle(reviewing, qtbot)
    reviewing.context.session.document.go_to(0)
    reviewing.features.review.plot.go_above(1)
    assert reviewing.context.session.document.frame == 5  # the wild run is 90 degrees off there
    port = plot._plot.viewport()

    def at(value):
        scene = plot._box.mapViewToScene(QPointF(1.0, value))
        return plot._plot.mapFromScene(scene)

    start, end = at(plot.threshold), at(1.0)
    qtbot.mouseMove(port, start)
    qtbot.wait(20)
    qtbot.mousePress(port, LEFT, pos=start)
    for share in (0.3, 0.6, 1.0):
        qtbot.mouseMove(port, start + (end - start) * share)
        qtbot.wait(20)
    qtbot.mouseRelease(port, LEFT, pos=end)
    assert plot.threshold < 2.5
    settle(reviewing, qtbot)
    heading = reviewing.features.review.panels.statistics.tree.headerItem().text(5)
    assert heading == f"> {plot.threshold:.0f}°"
    reviewing.context.session.document.go_to(3)
    reviewing.features.review.plot.go_above(1)
    assert reviewing.context.session.document.frame == 0  # all frames are one stretch above
    assert "coming round from the end" in reviewing.statusBar().currentMessage()
    reviewing.context.session.document.go_to(3)
    reviewing.features.review.plot.go_above(-1)
    assert reviewing.context.session.document.frame == 0
