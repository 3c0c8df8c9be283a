"""The history as a list: it follows every edit, and a click goes to any of them."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import Qt

from app.features.annotate.history import HistoryPresenter
from app.session.edits import EditStack
from app.widgets.tables.history_panel import HistoryModel, HistoryPanel
from stereotrack_core.annotation.click import Click, ClickKey
from stereotrack_core.project.clicks import MoveClicks, place
from stereotrack_core.project.entries import SaveEntry
from stereotrack_core.project.schema import RUN

LEFT = Qt.MouseButton.LeftButton


def edits(project, count, start=0):
    for frame in range(start, start + count):
        project.apply(place(Click(frame, "N", "head", (1.0, 2.0))))


@pytest.fixture
def panel(project, shown):
    made = HistoryPanel()
    edits_of_project = EditStack(made)
    edits_of_project.set_project(project)
    presenter = HistoryPresenter(edits_of_project, made)
    made.jump_requested.connect(presenter.jump_to)
    made.stop_requested.connect(presenter.stop)
    presenter.moved.connect(made.show_going)
    presenter.arrived.connect(lambda: made.show_going(None))
    made.show_edits(edits_of_project.entries)
    project.on_change(edits_of_project.follow)
    edits_of_project.changed.connect(made.follow)
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


def kept(project, name):
    """Keep something in place of a run; what it holds does not matter to the history."""
    project.apply(SaveEntry(RUN.name, name, "{}", name.encode()))


def test_a_run_that_was_kept_is_listed_and_passed_by(qtbot, project, panel):
    edits(project, 2)
    for name in ("a", "b", "c", "d"):
        kept(project, name)
    edits(project, 1, start=2)
    assert panel.model.index(4, 0).data() == "save run a"
    click_on(qtbot, panel, 2)
    assert project.clicks.count() == 3, "a run that was kept is no place to go to"
    click_on(qtbot, panel, 6)
    assert (project.clicks.count(), panel.model.current) == (1, 6)
    click_on(qtbot, panel, 0)
    assert (project.clicks.count(), panel.model.current) == (3, 0)
    assert len(project.runs.names()) == 4


def test_following_runs_that_are_kept_is_the_same_as_reading_everything(project):
    model = HistoryModel()
    model.open(project.history.entries)
    rng = np.random.default_rng(5)
    for step in range(300):
        if (turn := rng.integers(6)) == 0:
            project.redo()
        elif turn < 3:
            project.undo()
        elif turn == 3:
            edits(project, 1, start=step)
        else:
            kept(project, f"run {step}")
        model.follow()
        afresh = HistoryModel()
        afresh.open(lambda _limit, before: project.history.entries(400, before))
        assert rows_of(model)[: len(project.history.entries(400))] == [
            (entry.number, entry.state) for entry in project.history.entries(400)
        ]
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
