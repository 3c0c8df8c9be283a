"""Two readings become one by decisions, click by click, in one edit."""

from __future__ import annotations

import pytest

from stereotrack_core.annotation.click import UNCERTAIN, Click, ClickKey, Visibility
from stereotrack_core.errors import InputError
from stereotrack_core.project.clicks import DeleteClicks, PlaceClicks, place
from stereotrack_core.project.merging import has_mean, incoming, mean_click


def click(frame, x, landmark="head", **more):
    return Click(frame, "N_right", landmark, (x, 10.0), **more)


@pytest.fixture
def compared(project):
    project.apply(PlaceClicks((click(0, 1.0), click(1, 1.0), click(2, 1.0), click(3, 1.0))))
    theirs = [click(0, 5.0), click(1, 5.0), click(2, 5.0), click(3, 1.0), click(4, 7.0)]
    return incoming(project.clicks.all(with_deleted=True), theirs, "B")


def test_each_click_as_decided_and_undone_at_once(project, compared):
    keys = [ClickKey(frame, "N_right", "head") for frame in range(5)]
    edit = compared.edit({keys[1]: "theirs", keys[2]: "mean"})
    assert edit.words() == "merge 3 clicks, 1 of them mean positions, from B"
    project.apply(edit)
    assert [project.clicks.get(key).position[0] for key in keys] == [1.0, 5.0, 3.0, 1.0, 7.0]
    assert project.clicks.get(keys[2]).origin == "merged"
    project.undo()
    assert project.clicks.count() == 4
    assert project.clicks.get(keys[2]).position == (1.0, 10.0)


def test_a_mean_is_as_doubtful_as_the_worse_of_both(project):
    project.apply(place(click(0, 2.0, sigma=2.0, flag=UNCERTAIN)))
    theirs = click(0, 4.0, sigma=2.0, visibility=Visibility.GUESSED)
    found = incoming(project.clicks.all(), [theirs], "B").conflicts[0]
    mean = mean_click(found)
    assert mean.position == (3.0, 10.0)
    assert mean.visibility == Visibility.GUESSED
    assert mean.flag == UNCERTAIN
    assert mean.sigma == pytest.approx(2.0 / 2**0.5)


def test_there_is_no_mean_with_a_click_that_is_gone(project):
    project.apply(place(click(0, 2.0)))
    project.apply(DeleteClicks((click(0, 2.0).key,)))
    found = incoming(project.clicks.all(with_deleted=True), [click(0, 4.0)], "B")
    assert not has_mean(found.conflicts[0])
    with pytest.raises(InputError, match="one side only"):
        found.edit({click(0, 2.0).key: "mean"})
