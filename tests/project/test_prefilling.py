"""Predictions are kept beside clicks, never over them; a person takes them by an edit."""

from __future__ import annotations

import pytest

from stereotrack_core.annotation.click import Click, ClickKey, Prediction, Visibility
from stereotrack_core.errors import InputError
from stereotrack_core.project.clicks import DeleteClicks, MoveClicks, PlaceClicks
from stereotrack_core.project.project import Project


def predicted(frame, camera="N_right", landmark="left_elbow", sigma=3.0, source="fit"):
    return Prediction(frame, camera, landmark, source, (10.0 + frame, 20.0), sigma)


def test_predictions_go_where_nobody_has_said_anything(project):
    deleted = ClickKey(2, "N_right", "left_elbow")
    project.apply(
        PlaceClicks(
            (
                Click(0, "N_right", "left_elbow", (1.0, 2.0)),
                Click(1, "N_right", "left_elbow", None, Visibility.OUTSIDE),
                Click(*deleted, (5.0, 5.0)),
            )
        )
    )
    project.apply(DeleteClicks((deleted,)))
    before = project.clicks.all(with_deleted=True)
    all_of_them = [
        predicted(frame, camera) for frame in range(3) for camera in ("N_right", "S_cam")
    ]
    assert project.predictions.replace("fit", all_of_them) == 3
    assert {one.camera for one in project.predictions.of_source("fit")} == {"S_cam"}
    assert project.clicks.all(with_deleted=True) == before


def test_some_frames_can_be_kept_anew_and_the_others_stay(project):
    project.predictions.replace("fit", [predicted(frame) for frame in range(3)])
    project.predictions.replace("run a", [predicted(1, source="run a")])
    assert project.predictions.replace("fit", [predicted(1, sigma=9.0)], frames=range(1, 2)) == 1
    kept = {one.frame: one.sigma for one in project.predictions.of_source("fit")}
    assert kept == {0: 3.0, 1: 9.0, 2: 3.0}
    assert project.predictions.replace("fit", [], frames=range(2)) == 0
    assert [one.frame for one in project.predictions.of_source("fit")] == [2]
    assert len(project.predictions.of_source("run a")) == 1
    with pytest.raises(ValueError, match="not all"):
        project.predictions.replace("fit", [predicted(1, source="run a")])


def test_a_selection_is_taken_by_one_edit_and_can_be_undone(project):
    many = [
        predicted(frame, landmark=landmark, sigma=sigma)
        for frame in range(3)
        for landmark, sigma in (("left_elbow", 2.0), ("left_hand", 8.0))
    ]
    project.predictions.replace("fit", many)
    project.apply(PlaceClicks((Click(1, "N_right", "left_elbow", (1.0, 2.0)),)))
    edit = project.predictions.acceptance("fit", range(2), {"left_elbow"})
    project.apply(edit)
    clicks = {click.key: click for click in project.clicks.all()}
    assert {key.frame for key in clicks} == {0, 1}
    assert clicks[ClickKey(0, "N_right", "left_elbow")].origin == "accepted"
    assert clicks[ClickKey(1, "N_right", "left_elbow")].position == (1.0, 2.0)
    project.undo()
    assert project.clicks.count() == 1
    assert project.predictions.acceptance("fit", landmarks={"head"}) is None
    assert project.predictions.acceptance("other") is None


def test_a_click_that_was_accepted_and_moved_is_a_person_s_own(project):
    project.predictions.replace("fit", [predicted(0)])
    project.apply(project.predictions.acceptance("fit"))
    key = ClickKey(0, "N_right", "left_elbow")
    project.apply(MoveClicks((key,), (0.5, 0.0)))
    assert project.clicks.get(key).origin == "hand"
    project.undo()
    assert project.clicks.get(key).origin == "accepted"


def test_a_project_for_reading_takes_none(project, project_path):
    project.close()
    with (
        Project.open(project_path, read_only=True) as reading,
        pytest.raises(InputError, match="read"),
    ):
        reading.predictions.replace("fit", [predicted(0)])
