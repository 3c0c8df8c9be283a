"""The history as a list: it follows every edit, and a click goes to any of them."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import Qt

from app.features.annotate.history import HistoryPresenter
from app.widgets.tables.history_panel import HistoryModel, HistoryPanel
from stereotrack_core.annotation.click import Click, ClickKey
from stereotrack_core.project.clicks import MoveClicks, place

LEFT = Qt.MouseButton.LeftButton


def edits(project, count, start=0):
    for frame in range(start, start + count):
        project.apply(place(Click(frame, "N", "head", (1.0, 2.0))))


@pytest.fixture
def panel(project, shown):
    made = HistoryPanel()
    presenter = HistoryPresenter(made)
    presenter.set_project(project)
    made.jump_requested.connect(presenter.jump_to)
    made.stop_requested.connect(presenter.stop)
    presenter.moved.connect(made.show_going)
    presenter.arrived.connect(lambda: made.show_going(None))
    made.show_edits(project.history.entries)
    project.on_change(lambda _changed: made.follow())
    made.presenter = presenter
    return shown(made, 420, 400)


def click_on(qtbot, panel, row):
    area = panel.tree.visualRect(panel.model.index(row, 0))
    qtbot.mouseClick(panel.tree.viewport(), LEFT, pos=area.center())
    qtbot.waitUntil(lambda: not panel.presenter.jumping, timeout=5_000)


def rows_of(model):
    count = model.rowCount()
    return [(e.number, e.state) if (e := model.rows[row]) else None for row in range(count)]


def test_every_edit_is_a_row_and_a_click_goes_there(qtbot, project, panel):
    edits(project, 12)
    assert panel.model.index(0, 0).data() == "place head in N, frame 11"
    assert panel.model.index(0, 1).data() == project.who
    click_on(qtbot, panel, 5)
    assert sorted(project.clicks.frames().tolist()) == list(range(7))
    assert panel.model.current == 5
    click_on(qtbot, panel, 2)
    assert len(project.clicks.frames()) == 10
    click_on(qtbot, panel, 12)
    assert panel.model.rows[12] is None
    assert project.clicks.count() == 0
    click_on(qtbot, panel, 0)
    assert project.clicks.count() == 12


def test_enter_goes_there_too(qtbot, project, panel):
    edits(project, 4)
    panel.tree.setCurrentIndex(panel.model.index(3, 0))
    qtbot.keyClick(panel.tree, Qt.Key.Key_Return)
    qtbot.waitUntil(lambda: project.clicks.count() == 1, timeout=5_000)


def test_what_was_replaced_by_another_edit_cannot_be_chosen(qtbot, project, panel):
    edits(project, 3)
    project.undo()
    project.undo()
    edits(project, 1, start=30)
    assert [state for _, state in rows_of(panel.model)[:4]] == [
        *("done", "dropped", "dropped", "done")
    ]
    click_on(qtbot, panel, 1)
    assert project.clicks.count() == 2


def test_many_small_steps_stay_one_row(project, panel):
    edits(project, 1)
    for _ in range(5):
        project.apply(MoveClicks((ClickKey(0, "N", "head"),), (0.5, 0.0)), continues=True)
    assert panel.model.rowCount() == 3  # the place, the way, the beginning


def test_following_is_the_same_as_reading_everything(project):
    model = HistoryModel()
    model.open(project.history.entries)
    rng = np.random.default_rng(2)
    for step in range(400):
        if (turn := rng.integers(6)) == 0:
            project.redo()
        elif turn < 3:
            project.undo()
        else:
            edits(project, 1, start=step)
        model.follow()
    afresh = HistoryModel()
    afresh.open(project.history.entries)
    while afresh.canFetchMore(model.index(-1, -1)):
        afresh.fetchMore(model.index(-1, -1))
    assert rows_of(model) == rows_of(afresh)
    assert model.current == afresh.current


def test_only_what_is_looked_at_is_read(qtbot, project, shown):
    edits(project, 900)
    asked = []

    def fetch(limit, before=None):
        asked.append(limit)
        return project.history.entries(limit, before)

    panel = HistoryPanel()
    panel.show_edits(fetch)
    shown(panel, 420, 400)
    assert sum(asked) < 500

    def everything():
        panel.tree.scrollToBottom()
        return panel.model.rowCount() == 901

    qtbot.waitUntil(everything)


def test_a_long_way_can_be_stopped(qtbot, project, panel):
    edits(project, 400)
    panel.presenter.jump_to(project.history.entries()[-1])
    qtbot.waitUntil(panel.going.isVisible, timeout=5_000)
    qtbot.mouseClick(panel.stop_button, LEFT)
    assert 1 < project.clicks.count() < 400
    assert not panel.going.isVisible()
