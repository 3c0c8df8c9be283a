"""Predictions are kept beside clicks, never over them; a person takes them by an edit."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.annotation.click import Click, ClickKey, Prediction, Visibility
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.errors import InputError
from stereotrack_core.project.clicks import delete_clicks, move_clicks, place_clicks
from stereotrack_core.project.predictions import DetectorState
from stereotrack_core.project.prefilling import (
    accept_predictions,
    detector_filling,
    fill_in,
    from_fit,
    from_run,
)
from stereotrack_core.project.selection import Selection
from stereotrack_core.recording.keypoints import keypoints_of
from stereotrack_core.recording.landmarks import LANDMARKS
from tests.annotation.fits import fit_of
from tests.annotation.scenes import bodies, cameras
from tests.project.test_runs import run

RIG = cameras()


def predicted(frame, camera="N_right", landmark="left_elbow", sigma=3.0, source="fit"):
    return Prediction(frame, camera, landmark, source, (10.0 + frame, 20.0), sigma)


def test_predictions_go_where_nobody_has_said_anything(project):
    deleted = ClickKey(2, "N_right", "left_elbow")
    project.apply(
        place_clicks(
            (
                Click(0, "N_right", "left_elbow", (1.0, 2.0)),
                Click(1, "N_right", "left_elbow", None, Visibility.OUTSIDE),
                Click(*deleted, (5.0, 5.0)),
            )
        )
    )
    project.apply(delete_clicks((deleted,)))
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


def test_keypoints_of_detectors_fill_a_selection_and_the_surest_is_accepted(project):
    rows = [
        (frame, "N_right", name, x, 20.0 * frame, sure, source, 0)
        for source, x, sure in (("rough", 10.0, 0.2), ("fine", 12.0, 0.9))
        for frame in range(3)
        for name in ("left_elbow", "left_wrist")
    ]
    project.keypoints.put(DetectorState(("rough", "fine"), keypoints_of(rows), ()))
    chosen = Selection(range(1, 3))
    said = fill_in(project, detector_filling(project, {}, AVERAGE), chosen)
    assert said == "8 points predicted from the keypoints."
    assert {one.landmark for one in project.predictions.at(1)} == {"left_elbow", "left_hand"}
    project.apply(accept_predictions(project, ("rough", "fine"), chosen, "points"))
    clicks = {click.key: click.position for click in project.clicks.all()}
    assert len(clicks) == 4
    assert clicks[ClickKey(1, "N_right", "left_elbow")] == (12.0, 20.0)
    with pytest.raises(InputError, match="no points in"):
        accept_predictions(project, ("rough",), Selection(range(1)), "points")


def test_a_click_that_was_accepted_and_moved_is_a_person_s_own(project):
    project.predictions.replace("fit", [predicted(0)])
    project.apply(accept_predictions(project, ("fit",), Selection(range(1)), "points"))
    key = ClickKey(0, "N_right", "left_elbow")
    project.apply(move_clicks((key,), (0.5, 0.0)))
    assert project.clicks.get(key).origin == "hand"
    project.undo()
    assert project.clicks.get(key).origin == "accepted"


def run_of(points):
    """A run of these landmarks, whose limbs are known to 5 degrees."""
    tracked, sigma = np.isfinite(points).any(axis=(1, 2)), np.full((len(points), 6), 5.0)
    return replace(run(len(points)), landmarks=points, tracked=tracked, limb_sigma_deg=sigma)


def test_fit_is_projected_into_every_image_that_shows_it():
    points = bodies(6)
    found = {one.key: one for one in from_fit(fit_of(points, [0, 5], unknown=[3]), RIG, range(9))}
    assert {key.frame for key in found} == {0, 1, 2, 4, 5}
    for name, camera in RIG.items():
        for place, landmark in enumerate(NINE.names):
            expected = camera.project(points[2, place])
            assert found[ClickKey(2, name, landmark)].position == pytest.approx(tuple(expected))
    known = [one for one in found.values() if one.key.landmark == "left_hand"]
    at_click = np.mean([one.sigma for one in known if one.frame in (0, 5)])
    between = np.mean([one.sigma for one in known if one.frame in (2, 4)])
    assert 1.0 < at_click < 4.0 < between  # 10 mm at about 2.8 m and 520 px, and what is unsure


def test_run_is_projected_where_it_is_tracked():
    points = bodies(4)
    points[2] = np.nan
    points[3, LANDMARKS.index("left_hand")] = np.nan
    found = list(from_run(run_of(points), "accurate", RIG, NINE, range(9)))
    assert {one.source for one in found} == {"run accurate"}
    assert {one.frame for one in found} == {0, 1, 3}
    assert not any(one.frame == 3 and one.landmark == "left_hand" for one in found)
    assert all(one.sigma > 2 for one in found)
    assert not list(from_run(run_of(points + [0, 0, 50.0]), "accurate", RIG, NINE, range(9)))
