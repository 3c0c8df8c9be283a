"""Two readings become one by one decision, in one edit."""

from __future__ import annotations

import pytest

from stereotrack_core.annotation.click import UNCERTAIN, Click, Visibility
from stereotrack_core.project.clicks import DeleteClicks, PlaceClicks, place
from stereotrack_core.project.merging import incoming


def click(frame, x, landmark="head", **more):
    return Click(frame, "N_right", landmark, (x, 10.0), **more)


def test_each_decision_holds_for_all_and_is_undone_at_once(project):
    project.apply(PlaceClicks((click(0, 1.0), click(1, 1.0), click(2, 1.0), click(3, 1.0))))
    project.apply(DeleteClicks((click(2, 1.0).key,)))
    theirs = [click(0, 1.0), click(1, 5.0), click(2, 5.0), click(4, 7.0)]
    found = incoming(project.clicks.all(with_deleted=True), theirs, "B")

    def places():
        return {one.frame: one.position[0] for one in project.clicks.all()}

    edit = found.edit("mean")
    assert edit.words() == "merge 2 clicks, 1 of them mean positions, from B"
    project.apply(edit)
    assert places() == {0: 1.0, 1: 3.0, 3: 1.0, 4: 7.0}  # no mean with a click that is gone
    assert project.clicks.get(click(1, 1.0).key).origin == "merged"
    project.undo()
    assert places() == {0: 1.0, 1: 1.0, 3: 1.0}
    project.apply(found.edit("theirs", with_new=False))
    assert places() == {0: 1.0, 1: 5.0, 2: 5.0, 3: 1.0}


def test_a_mean_is_as_doubtful_as_the_worse_of_both(project):
    project.apply(place(click(0, 2.0, sigma=2.0, flag=UNCERTAIN)))
    theirs = click(0, 4.0, sigma=2.0, visibility=Visibility.GUESSED)
    (mean,) = incoming(project.clicks.all(), [theirs], "B").edit("mean").clicks
    assert mean.position == (3.0, 10.0)
    assert mean.visibility == Visibility.GUESSED
    assert mean.flag == UNCERTAIN
    assert mean.sigma == pytest.approx(2.0 / 2**0.5)
