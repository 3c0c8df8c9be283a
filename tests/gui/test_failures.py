"""Failures in the window: found by themselves, listed, filtered, jumped to, looped."""

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from tests.gui.hands import frames_shown
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


def settle(window, qtbot):
    qtbot.waitUntil(window.context.tasks.settled, timeout=60_000)
    qtbot.waitUntil(
        lambda: window.context.tasks.settled() and not window.context.tasks.tasks, timeout=60_000
    )


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
    assert rows(reviewing)[0][3] == ""
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
    assert not evidence.picture.isNull()
    said, _, below = evidence.toHtml().partition("<img")
    assert "Frames 1 to 3" in said
    assert below, "the picture comes after the evidence"

    seen = frames_shown(reviewing)
    QTest.keyClick(reviewing, Qt.Key.Key_Space, SHIFT)
    assert reviewing.context.session.document.loop == range(7)
    qtbot.waitUntil(lambda: 6 in seen and 0 in seen[seen.index(6) :], timeout=10_000)
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
    panel.filter.setText("head")
    settle(reviewing, qtbot)
    assert rows(reviewing) == []
    assert reviewing.context.session.failures.chosen is None
    assert reviewing.context.session.failures.none_listed() == "No failure is listed."
    panel.filter.setText("Left error")
    settle(reviewing, qtbot)
    assert len(rows(reviewing)) == 1
    settle(reviewing, qtbot)


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
