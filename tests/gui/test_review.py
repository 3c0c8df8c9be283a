"""The Review workspace: the plot, its threshold, and numbers of the selection."""

import pytest
from PySide6.QtCore import QPointF, Qt

from tests.gui.hands import settle, show_workspace, trigger
from tests.gui.made_runs import add_run

pytestmark = pytest.mark.window

LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def reviewing(opened, qtbot):
    """The Review workspace with two runs: one good, one wild in frames 5 and 6."""
    add_run(opened, "wild", off=0.1, wild=(5, 6))
    add_run(opened, "good", off=0.05)
    show_workspace(opened, qtbot, "review")
    return opened


def show(window, qtbot, name):
    window.context.docks.dock(name).raise_()
    window.context.docks.dock(name).show()
    qtbot.waitUntil(window.context.docks.dock(name).widget().isVisible)
    settle(window, qtbot)


def test_numbers_of_the_runs_are_of_the_selection(reviewing, qtbot):
    panel, timeline = reviewing.features.track.comparison, reviewing.context.docks.timeline
    show(reviewing, qtbot, "comparison")

    def lost():
        place = next(k for k, row in enumerate(panel.table.cells.rows) if "lost" in row[0].text)
        return [panel.table.cells.cell(place, column).text for column in (1, 2)]

    assert lost()[0] == "0.0"
    assert lost()[1] != "0.0", "in two frames of eight"
    timeline.set_selection(range(4))
    timeline.selection_changed.emit(range(4))
    settle(reviewing, qtbot)
    assert lost() == ["0.0", "0.0"]
    trigger(reviewing, "threshold_down")
    assert reviewing.features.review.plot.plot.threshold == 40.0


def test_without_truth_the_trackers_own_signs_are_shown_and_it_is_said(reviewing, qtbot):
    recording = reviewing.context.session.document.recording
    reviewing.context.view_state.set_threshold(12.0)
    object.__setattr__(recording, "reference", None)  # as if it had none
    reviewing.context.session.judging.judge()
    settle(reviewing, qtbot)
    assert reviewing.features.review.plot.plot._heading.text() != "angular error"
    assert reviewing.features.review.plot.plot.threshold == 12.0


def test_a_dragged_threshold_is_obeyed_by_next_and_previous(reviewing, qtbot):
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
    reviewing.context.session.document.go_to(3)
    reviewing.features.review.plot.go_above(1)
    assert reviewing.context.session.document.frame == 0  # all frames are one stretch above
    assert "coming round from the end" in reviewing.statusBar().currentMessage()
    reviewing.context.session.document.go_to(3)
    reviewing.features.review.plot.go_above(-1)
    assert reviewing.context.session.document.frame == 0
