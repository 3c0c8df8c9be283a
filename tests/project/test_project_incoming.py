"""Clicks of a file or another project are taken in without overwriting anybody's."""

from dataclasses import replace

import pytest

from stereotrack_core.annotation.click import UNCERTAIN, Click, Visibility
from stereotrack_core.errors import InputError
from stereotrack_core.interop.labels import read_clicks, write_clicks
from stereotrack_core.project.clicks import delete_clicks, mark_clicks, place, place_clicks
from stereotrack_core.project.merging import incoming
from stereotrack_core.project.project import Project

A = Click(0, "N_right", "left_elbow", (10.0, 20.0))
B = replace(A, frame=1)
C = replace(A, frame=2)


def positions(project: Project) -> dict[int, tuple[float, float] | None]:
    return {click.frame: click.position for click in project.clicks.all()}


@pytest.fixture
def second_project(recording, project_path):
    path = project_path.with_name("second.stereotrack")
    with Project.create(path, recording.folder, who="B") as made:
        moved, unlike = replace(B, position=(11.0, 20.0)), replace(C, camera="S_cam")
        made.apply(place_clicks((A, moved, unlike)))
    with Project.open(path, read_only=True) as reading:
        yield reading


def test_two_projects_are_merged_by_one_edit(project, second_project):
    project.apply(place_clicks((A, B, C)))
    theirs = second_project.clicks.all(with_deleted=True)
    found = incoming(project.clicks.all(with_deleted=True), theirs, "second")
    assert [click.camera for click in found.new] == ["S_cam"]
    assert [click.key for click in found.same] == [A.key]
    assert [one.key for one in found.conflicts] == [B.key]
    with pytest.raises(
        InputError, match=r"1 click already in the project differs.*frame 1.*Choose"
    ):
        found.edit()
    project.apply(found.edit("theirs"))
    assert project.clicks.get(B.key).position == (11.0, 20.0)
    assert project.clicks.get(B.key).who == "B"
    assert project.clicks.get(A.key).who == "A"
    assert project.clicks.count() == 4
    assert project.history.to_undo().words == "merge 2 clicks from second"
    project.undo()
    assert positions(project) == {0: A.position, 1: B.position, 2: C.position}
    project.apply(found.edit("mine"))
    assert project.clicks.get(B.key).position == B.position
    assert project.clicks.count() == 4


def test_a_deleted_click_does_not_come_back_by_itself(project):
    project.apply(place_clicks((A,)))
    project.apply(delete_clicks((A.key,)))
    found = incoming(project.clicks.all(with_deleted=True), [A], "a file")
    assert found.new == ()
    assert found.conflicts[0].kind == "only second"
    project.apply(found.edit("mine"))
    assert project.clicks.count() == 0
    project.apply(found.edit("theirs"))
    assert project.clicks.count() == 1


def test_a_clicks_file_goes_out_and_comes_in_again(project, recording, tmp_path):
    """Flag and sigma have no column; to read the file again must not ask or change them."""
    project.apply(place_clicks((A, B)))
    project.apply(mark_clicks((A.key,), flag="uncertain", sigma=5.0))
    path = tmp_path / "clicks.csv"
    write_clicks(path, project.clicks.all(), recording)
    clicks = read_clicks(path, recording).checked()
    mine = project.clicks.all(with_deleted=True)
    found = incoming(mine, clicks, path.name, unstated=("flag", "sigma"))
    assert (found.new, found.conflicts, len(found.same)) == ((), (), 2)
    assert project.apply(found.edit()) is None
    moved = replace(clicks[0], position=(30.0, 20.0))
    (conflict,) = incoming(mine, [moved], path.name, unstated=("flag", "sigma")).conflicts
    assert (conflict.second.flag, conflict.second.sigma) == ("uncertain", 5.0)


def test_a_file_of_places_alone_does_not_contradict_how_a_landmark_is_seen():
    mine = [Click(0, "S", "head", (1.0, 2.0), Visibility.GUESSED)]
    outside = [Click(0, "S", "head", None, Visibility.OUTSIDE)]
    theirs = [Click(0, "S", "head", (1.0, 2.0), origin="imported")]
    assert incoming(mine, theirs, "a.csv", unstated=("visibility",)).same
    assert incoming(mine, theirs, "a.csv").conflicts
    assert incoming(outside, theirs, "a.csv", unstated=("visibility",)).conflicts


def click(frame, x, landmark="head", **more):
    return Click(frame, "N_right", landmark, (x, 10.0), **more)


def test_each_decision_holds_for_all_and_is_undone_at_once(project):
    project.apply(place_clicks((click(0, 1.0), click(1, 1.0), click(2, 1.0), click(3, 1.0))))
    project.apply(delete_clicks((click(2, 1.0).key,)))
    theirs = [click(0, 1.0), click(1, 5.0), click(2, 5.0), click(4, 7.0)]
    found = incoming(project.clicks.all(with_deleted=True), theirs, "B")

    def places():
        return {one.frame: one.position[0] for one in project.clicks.all()}

    edit = found.edit("mean")
    assert edit.words == "merge 2 clicks, 1 of them mean positions, from B"
    project.apply(edit)
    assert places() == {0: 1.0, 1: 3.0, 3: 1.0, 4: 7.0}  # no mean with a click that is gone
    assert project.clicks.get(click(1, 1.0).key).origin == "merged"
    project.undo()
    assert places() == {0: 1.0, 1: 1.0, 3: 1.0}
    project.apply(found.edit("theirs"))
    assert places() == {0: 1.0, 1: 5.0, 2: 5.0, 3: 1.0, 4: 7.0}


def test_a_mean_is_as_doubtful_as_the_worse_of_both(project):
    project.apply(place(click(0, 2.0, sigma=2.0, flag=UNCERTAIN)))
    theirs = click(0, 4.0, sigma=2.0, visibility=Visibility.GUESSED)
    (mean,) = incoming(project.clicks.all(), [theirs], "B").taken("mean")
    assert mean.position == (3.0, 10.0)
    assert mean.visibility == Visibility.GUESSED
    assert mean.flag == UNCERTAIN
    assert mean.sigma == pytest.approx(2.0 / 2**0.5)
