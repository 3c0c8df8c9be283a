"""The landmarks of the body that a detector's keypoints show in several images."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from stereotrack_core.annotation import detected_body
from stereotrack_core.annotation.click import Visibility
from stereotrack_core.annotation.detected_body import (
    DetectLandmarks,
    body_predictions,
    landmark_predictions,
)
from stereotrack_core.annotation.propose import acceptable
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.pose_model.detect import DETECTOR_NAME
from stereotrack_core.recording.keypoint_names import exchanged
from stereotrack_core.recording.keypoints import keypoints_of, rows_of
from stereotrack_core.recording.landmarks import LANDMARKS
from tests.simulated_keypoints import KeypointErrors, simulated_keypoints
from tests.tracking.keypoints.mono import mono_recording, truth

EXACT = KeypointErrors(noise=0.3, gross=0.0, exchanged=0.0, hidden_missing=0.0, guess=1.0)


@pytest.fixture(scope="module")
def cameras(tmp_path_factory):
    return mono_recording(tmp_path_factory.mktemp("mono")).cameras


def seen_in(cameras, frames, errors=EXACT, seed=3):
    seen = simulated_keypoints(truth(), cameras, errors, seed=seed)
    return seen[np.isin(seen.frame, frames)]


def off(found, cameras):
    """Pixels (n, 2) from the truth."""
    places = dict(zip(truth().frame.tolist(), truth().points, strict=True))
    return np.array(
        [
            cameras[one.camera].project(places[one.frame][LANDMARKS.index(one.landmark)])
            - one.position
            for one in found
        ]
    )


def predicted(keypoints, cameras):
    return list(body_predictions(keypoints, LANDMARKS, cameras, AVERAGE))


def test_all_images_get_all_landmarks_also_those_that_show_no_keypoint(cameras):
    seen = seen_in(cameras, [0])
    hidden = seen[~((seen.camera == "N") & np.isin(seen.keypoint, ["left_elbow", "right_hip"]))]
    found = predicted(hidden, cameras)
    assert len(found) == 9 * len(cameras)
    assert len(landmark_predictions(hidden, LANDMARKS)) < len(found)
    assert all(one.sigma > 0 for one in found)
    assert np.median(np.linalg.norm(off(found, cameras), axis=1)) < 3.0


def test_frames_are_detected_one_by_one_and_guessed_cameras_place_nothing(tmp_path, monkeypatch):
    recording, searches = mono_recording(tmp_path), []
    monkeypatch.setattr(detected_body, "required_detector", lambda: "the detector")
    monkeypatch.setattr(detected_body, "person_boxes", lambda *_: searches.append(1) or {})
    monkeypatch.setattr(
        detected_body, "detect_keypoints",
        lambda reader, _model, frames, **_: seen_in(reader.recording.cameras, list(frames)),
    )  # fmt: skip
    asker = SimpleNamespace(kept={}, cancelled=lambda: False)
    found = [DetectLandmarks(recording, k, LANDMARKS, AVERAGE)(asker) for k in (0, 3)]
    assert [{one.frame for one in each} for each in found] == [{0}, {3}]
    assert len(found[0]) == 9 * len(recording.cameras)
    assert len(searches) == 1, "where anything moves is looked for once"
    guessed = replace(recording, guessed=True)
    alone = DetectLandmarks(guessed, 0, LANDMARKS, AVERAGE)(asker)
    assert list(alone) == list(landmark_predictions(seen_in(recording.cameras, [0]), LANDMARKS))


@pytest.mark.parametrize("arms", [False, True])
def test_sides_exchanged_in_one_image_are_exchanged_back(cameras, arms):
    rows = list(rows_of(seen_in(cameras, [0])))
    wrong = keypoints_of(
        [
            (frame, camera, exchanged(name), *rest)
            if camera == "S" and (not arms or "elbow" in name or "wrist" in name)
            else (frame, camera, name, *rest)
            for frame, camera, name, *rest in rows
        ]
    )
    before = predicted(keypoints_of(rows), cameras)
    for one, other in zip(before, predicted(wrong, cameras), strict=True):
        assert one.key == other.key
        assert np.allclose(one.position, other.position, atol=1e-6)


def test_a_keypoint_that_other_images_contradict_moves_little_and_makes_unsure(cameras):
    rows = list(rows_of(seen_in(cameras, [0])))
    k = next(k for k, row in enumerate(rows) if row[1:3] == ("N", "left_shoulder"))
    wrong = [*rows]
    wrong[k] = (*rows[k][:3], rows[k][3] + 20.0, *rows[k][4:])

    def shoulder(rows):
        found = predicted(keypoints_of(rows), cameras)
        return next(one for one in found if one.camera == "N" and one.landmark == "left_shoulder")

    right, moved = shoulder(rows), shoulder(wrong)
    assert np.hypot(*np.subtract(right.position, moved.position)) < 3.0
    assert moved.sigma > 1.2 * right.sigma


def test_standard_deviations_are_true_for_a_detector_that_errs(cameras):
    errors = KeypointErrors(noise=1.0, gross=0.05, exchanged=0.1)
    seen = seen_in(cameras, [0, 2, 4, 6], errors, seed=8)
    found = predicted(seen, cameras)
    scaled = np.abs(off(found, cameras)) / np.array([[one.sigma] for one in found])
    assert 0.55 < np.mean(scaled < 1.0) < 0.99
    assert np.mean(scaled < 2.0) > 0.9
    taken = acceptable(found, (), cameras).predictions
    assert taken
    assert np.mean(np.linalg.norm(off(taken, cameras), axis=1) > 10.0) < 0.05


def test_points_of_the_installed_detector_lie_beside_the_landmarks(cameras):
    seen = list(rows_of(seen_in(cameras, [0])))
    other = predicted(keypoints_of(seen), cameras)
    own = predicted(keypoints_of([(*row[:6], DETECTOR_NAME, 0) for row in seen]), cameras)
    before = {one.key: one.position for one in other}

    def moved(name):
        pairs = [(one.position, before[one.key]) for one in own if one.landmark == name]
        return np.median([np.hypot(*np.subtract(*pair)) for pair in pairs])

    assert moved("left_elbow") > 2.0 * moved("head")


def test_landmarks_behind_the_body_are_accepted_as_guessed(cameras):
    found = predicted(seen_in(cameras, [0]), cameras)
    hidden = {one.key for one in found if one.visibility == Visibility.GUESSED}
    assert 0 < len(hidden) < len(found) / 2
    taken = acceptable(found, (), cameras, 100.0).predictions
    assert {one.key for one in taken if one.visibility == Visibility.GUESSED} == hidden
