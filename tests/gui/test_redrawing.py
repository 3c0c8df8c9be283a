"""What changes is drawn, once, and nothing else; runs are judged off the window's thread."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt, QTimer
from PySide6.QtTest import QTest

from tests.gui.hands import Paintings, click_truth
from tests.gui.made_runs import add_run
from tests.gui.tuning.conftest import quick_run_file, tuning  # noqa: F401
from tests.gui.tuning.test_tuning import typed

pytestmark = pytest.mark.window


class Drawings:
    """Counts how often the parts of a window are given something to draw."""

    def __init__(self, window, monkeypatch):
        docks, review = window.context.docks, window.features.review
        self.count = {}
        for name, part, method in (
            ("pictures", docks.views, "show_pictures"),
            ("lanes", docks.timeline, "set_lanes"),
            ("curves", review.plot.plot, "set_curves"),
            ("failures", review.failures.panel, "show_rows"),
            ("statistics", review.panels.statistics, "show_statistics"),
        ):
            self.count[name] = 0
            monkeypatch.setattr(part, method, self._counted(name, getattr(part, method)))

    def _counted(self, name, draw):
        def counted(*what, **how):
            self.count[name] += 1
            draw(*what, **how)

        return counted

    def taken(self):
        """How often since this was asked last."""
        taken = {name: count for name, count in self.count.items() if count}
        self.count = dict.fromkeys(self.count, 0)
        return taken


def settle(window, qtbot):
    qtbot.waitUntil(lambda: window.context.tasks.settled() and not window.context.tasks.tasks)


def show(window, qtbot, name):
    window.context.docks.bring_up(name)
    qtbot.waitUntil(window.context.docks.dock(name).widget().isVisible)
    settle(window, qtbot)


def test_a_click_is_drawn_where_it_is_and_then_what_is_known_of_it(annotating, qtbot, monkeypatch):
    docks = annotating.context.docks
    settle(annotating, qtbot)
    views = {name: Paintings(tile.camera) for name, tile in docks.views.tiles.items()}
    timeline = Paintings(docks.timeline.viewport())
    drawings = Drawings(annotating, monkeypatch)
    click_truth(annotating, "left_elbow", "N")
    settle(annotating, qtbot)
    assert views["N"].count <= 2
    assert views["S"].count <= 1, "there is a curve of it"
    assert 1 <= timeline.count <= 2, "the click, and what is proposed for the next frame"
    assert drawings.taken() == {"lanes": timeline.count}


def test_the_window_answers_between_pictures_and_before_the_scene(opened, qtbot):
    opened.context.docks.show_named("track")
    settle(opened, qtbot)
    qtbot.waitUntil(opened.context.docks.scene.at_rest)
    rounds, painted = [0], []

    def count():
        rounds[0] += 1

    beat = QTimer(opened, interval=0)
    beat.timeout.connect(count)
    beat.start()
    parts = [tile.camera for tile in opened.context.docks.views.tiles.values()]
    for part in (*parts, opened.context.docks.scene):
        Paintings(part, lambda part=part: painted.append((part, rounds[0])))
    opened.context.session.document.go_to(5)
    settle(opened, qtbot)
    beat.stop()
    # a fine picture of the frame before may still come first
    begin = next(k for k, (part, _) in enumerate(painted) if part in parts)
    shown = painted[begin : begin + 3]
    assert [part for part, _ in shown] == [*parts, opened.context.docks.scene]
    assert len({at for _, at in shown}) == 3


def test_a_failure_that_is_chosen_is_shown_and_nothing_else_is_drawn(opened, qtbot, monkeypatch):
    opened.context.docks.show_named("review")
    add_run(opened, "wild", off=0.05, wild=(1, 2, 3))
    show(opened, qtbot, "failures")
    opened.context.session.document.go_to(7)
    settle(opened, qtbot)
    panel = opened.features.review.failures.panel
    panel.tree.setFocus()
    drawings = Drawings(opened, monkeypatch)
    panel.tree.setCurrentIndex(panel.sorted.index(0, 0))
    settle(opened, qtbot)
    assert drawings.taken() == {"failures": 1}
    views = [Paintings(tile.camera) for tile in opened.context.docks.views.tiles.values()]
    timeline = Paintings(opened.context.docks.timeline.viewport())
    QTest.keyClick(panel.tree, Qt.Key.Key_Return)
    settle(opened, qtbot)
    assert opened.context.session.document.frame in (1, 2, 3)
    assert set(drawings.taken()) == {"pictures"}
    assert [view.count for view in views] == [1, 1]
    assert timeline.count == 1


def test_a_trial_draws_its_curves_and_its_model_and_no_lanes(tuning, qtbot, monkeypatch):  # noqa: F811
    judging, runs = tuning.context.session.judging, tuning.context.session.runs
    drawings, seen = Drawings(tuning, monkeypatch), []

    def note():
        found = judging.of(runs.entries[-1])
        if runs.entries[-1] is not runs.active and found is not None and found not in seen:
            seen.append(found)

    judging.judged.connect(note)
    typed(tuning, "sigma_joint", "25")
    settle(tuning, qtbot)
    judging.judged.disconnect(note)
    taken = drawings.taken()
    assert len(seen[-1].frame) == 8
    assert taken.pop("pictures") == 1, "in the frame that is shown"
    assert 1 <= taken.pop("curves") <= len(seen), "once for all that is judged in the meantime"
    assert not taken
