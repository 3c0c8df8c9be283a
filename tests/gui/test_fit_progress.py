"""A fit of the whole recording says what it does until it is over, and can be stopped."""

import multiprocessing
import time

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from app.features.annotate.filling import reference_work
from tests.gui.hands import LEFT, annotate_all, key, trigger

pytestmark = pytest.mark.window


def endless_fit(fit, asker):
    """A fit that has taken all frames in and then goes on for longer than anybody waits."""
    asker.on_frames(len(fit.args[2].frames))
    asker.tell(0)
    time.sleep(600.0)


def test_a_fit_that_takes_long_is_seen_to_work_and_can_be_cancelled(annotating, qtbot, monkeypatch):
    window = annotating
    window.features.annotate.clicking.toggle_depth()
    annotate_all(window, qtbot)
    monkeypatch.setattr(reference_work, "fit_elsewhere", endless_fit)
    before = multiprocessing.active_children()
    window.context.actions.refresh()
    assert "(under a second)" in window.context.actions.action("annotate-fit").text()
    trigger(window, "annotate-fit")
    qtbot.waitUntil(lambda: "forward and backward pass" in window.status.state.text())
    assert "fitting the body to the clicks" in window.status.state.text()
    assert window.status.progress.isVisible()
    assert (window.status.progress.minimum(), window.status.progress.maximum()) == (0, 0), (
        "busy: no end known"
    )
    first = window.status.state.text()
    qtbot.waitUntil(lambda: window.status.state.text() != first)
    (child,) = (one for one in multiprocessing.active_children() if one not in before)
    QTest.mouseClick(window.status.cancel, LEFT)
    qtbot.waitUntil(lambda: not window.features.annotate.panels.reference.fitting)
    assert not child.is_alive(), "nothing goes on computing"
    assert window.context.session.project.project.references.names() == ()
    qtbot.waitUntil(window.context.tasks.settled)
    assert not window.status.progress.isVisible()
    assert window.messages.text() == ""


def test_suggestions_come_at_once_from_the_clicked_frames_alone(annotating, qtbot):
    window, panels = annotating, annotating.features.annotate.panels
    annotate_all(window, qtbot)
    key(window, Qt.Key.Key_J)
    qtbot.waitUntil(window.context.tasks.settled)
    assert window.context.session.project.project.references.names() == (), "no whole fit"
    assert window.context.session.document.frame > 0, "it goes where nothing is known"
    first = panels.next_panel.tree.cells.rows[0]
    assert first.kind == "unknown"
    rows = (panels.next_panel.tree.cells.cell(0, column).text for column in range(5))
    assert "all" in [*rows], "not some hundreds of degrees"
    window.context.session.document.visit(first.frame)
    qtbot.waitUntil(window.context.tasks.settled)
    annotate_all(window, qtbot)
    assert all(one.frame != first.frame or one.kind != "unknown"
               for one in panels.next_panel.tree.cells.rows)  # fmt: skip
