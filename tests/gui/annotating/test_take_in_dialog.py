"""Clicks from elsewhere are looked at before they are written, and written as decided."""

from dataclasses import replace
from types import SimpleNamespace

import pytest
from PySide6.QtCore import Qt

from app.features.annotate.exchange.merging import TakeInDialog
from stereotrack_core.annotation.click import ClickKey, Visibility
from stereotrack_core.project.clicks import delete_clicks, place, place_clicks
from stereotrack_core.project.merging import incoming
from tests.gui.annotating.notices import Notices

LEFT = Qt.MouseButton.LeftButton


def moved(click, by):
    return replace(click, position=(click.position[0] + by, click.position[1]))


@pytest.fixture
def theirs(project, make):
    """Of frame 3 equal, of 5 moved, deleted or outside, of 9 new."""
    mine = make.clicks_at([3, 5])
    project.apply(place_clicks(mine))
    deleted = next(c for c in mine if c.key == ClickKey(5, "S", "head"))
    project.apply(delete_clicks((deleted.key,)))
    changed = [c for c in mine if c.frame == 5 and c.camera in ("N", "S") and c.landmark == "head"]
    outside = next(c for c in mine if c.key == ClickKey(5, "W", "head"))
    return [
        *(c for c in mine if c.frame == 3),
        *(moved(c, 4.0) for c in changed),
        replace(outside, position=None, visibility=Visibility.OUTSIDE),
        *make.clicks_at([9]),
    ]


def take(qtbot, dialog):
    """Click on Take in, and wait until that is done or was refused."""
    qtbot.mouseClick(dialog.accept_button, LEFT)
    qtbot.waitUntil(lambda: not dialog._context.tasks.tasks)


@pytest.fixture
def dialog(project, theirs, shown, tasks):
    def compare():
        mine = project.clicks.all(with_deleted=True)
        return incoming(mine, theirs, "clicks of B")

    context = SimpleNamespace(tasks=tasks, notifier=Notices())
    return shown(TakeInDialog(project, compare, compare(), (), context), 560, 240)


def test_it_counts_before_anything_is_written(project, dialog):
    assert dialog.summary.text() == (
        "clicks of B: 36 new, 36 equal, 3 differ (1 moved, 1 different visibility, 1 deleted on "
        "one side)."
    )
    assert dialog.outcome.text() == (
        "36 clicks will be written, 3 conflicts keep the project's click."
    )
    assert project.clicks.count() == 71


def test_mine_stays_where_nothing_is_decided(qtbot, project, dialog):
    before = {c.key: c for c in project.clicks.all()}
    take(qtbot, dialog)
    assert dialog._context.notifier.said == ["merge 36 clicks from clicks of B"]
    after = {c.key: c for c in project.clicks.all()}
    assert {key: after[key] for key in before} == before
    assert len(after) == len(before) + 36
    project.undo()
    assert project.clicks.count() == 71


def choose(dialog, decision):
    dialog.decision.setCurrentIndex(dialog.decision.findData(decision))


def test_one_choice_holds_for_all_that_differ(qtbot, project, dialog):
    x = project.clicks.get(ClickKey(5, "N", "head")).position[0]
    choose(dialog, "theirs")
    assert dialog.outcome.text() == "39 clicks will be written."
    choose(dialog, "mean")  # one of the three has a place on both sides
    assert dialog.outcome.text() == (
        "37 clicks will be written, 2 conflicts keep the project's click."
    )
    take(qtbot, dialog)
    assert project.clicks.get(ClickKey(5, "N", "head")).position[0] == pytest.approx(x + 2.0)
    assert project.clicks.count() == 71 + 36


def test_a_project_that_changed_meanwhile_is_compared_again(qtbot, project, dialog, make):
    mine = make.clicks_at([9], sigma=5.0)[0]
    project.apply(place(mine))
    take(qtbot, dialog)
    assert not dialog.isVisible()
    assert project.clicks.get(mine.key).position == mine.position, "it was decided to keep mine"
    assert project.clicks.count() == 71 + 36
