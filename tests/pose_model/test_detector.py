"""The pretrained detector on a rendered person, where it is installed."""

import os

import cv2
import numpy as np
import pytest

from stereotrack_core.pose_model.detect import Whereabouts, detect_person
from stereotrack_core.pose_model.detector import POINT_NAMES
from stereotrack_core.pose_model.installation import FOLDER_VARIABLE
from stereotrack_core.program import main
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.recording.landmarks import LANDMARKS
from stereotrack_core.recording.reader import FrameReader
from stereotrack_core.simulation.make import Simulation, simulate
from tests.pose_model.installed import installed_detector

JOINTS = [f"{side}_{name}" for name in ("shoulder", "elbow", "hip") for side in ("left", "right")]


@pytest.fixture(scope="module")
def detector():
    return installed_detector()


@pytest.fixture(scope="module")
def recording(detector, tmp_path_factory):
    """One frame of a person in the T pose, about 250 pixels tall, from the front."""
    folder = tmp_path_factory.mktemp("detector") / "person"
    simulate(folder, Simulation(person="P3", motion="t-pose", frames=1, views="N", seed=3))
    return open_recording(folder)


@pytest.fixture(scope="module")
def picture(recording):
    with FrameReader(recording, read_ahead=0) as reader:
        return reader.frame_set(0).views["N"].image


@pytest.fixture(scope="module")
def camera(recording):
    return recording.reference_camera(recording.views[0])


@pytest.fixture(scope="module")
def truth(recording, camera):
    """Pixels (6, 2) of JOINTS, and of the middle of the hips."""
    points = recording.reference.points[0][[LANDMARKS.index(name) for name in JOINTS]]
    return camera.project(points), camera.project(points[4:].mean(axis=0))


def joints(pose) -> np.ndarray:
    return pose.points[[POINT_NAMES.index(name) for name in JOINTS]]


def misfit(pose, truth) -> np.ndarray:
    return np.linalg.norm(joints(pose) - truth[0], axis=1)


def test_the_person_is_found_in_the_whole_picture(detector, picture, truth):
    (person,) = detector.find_people(picture, least_height=np.inf)
    assert np.linalg.norm(person.hips - truth[1]) < 15
    assert 100 < person.radius < 170
    assert person.top[1] < truth[0][:, 1].min() - 30  # above the shoulders


def test_landmarks_are_where_the_joints_are(detector, picture, truth):
    pose = detector.landmarks(picture, detector.find_people(picture)[0].crop)
    assert pose.score > 0.9
    assert misfit(pose, truth).max() < 18  # 14 cm; the joints lie inside of the body
    assert np.median(misfit(pose, truth)) < 9
    assert (pose.visibility[[POINT_NAMES.index(name) for name in JOINTS]] > 0.8).all()


def test_a_small_person_is_found_in_tiles(detector, picture, truth):
    scale = 0.25  # some 60 pixels tall
    small = cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    wide = np.full((480, 640, 3), int(np.median(picture)), np.uint8)
    corner = np.array([410, 230])
    wide[corner[1] : corner[1] + 120, corner[0] : corner[0] + 160] = small
    assert not detector.find_people(wide, least_height=np.inf)
    person = detector.find_people(wide)[0]
    assert np.linalg.norm(person.hips - (corner + scale * truth[1])) < 8


def test_of_two_people_the_expected_one_is_taken(detector, picture, truth):
    pair, width = np.hstack([picture, picture]), picture.shape[1]
    assert len(detector.find_people(pair)) == 2
    for shift in (0, width):
        expected = truth[1] + [shift, 0]
        pose = detect_person(detector, pair, None, Whereabouts(expected))
        np.testing.assert_allclose(joints(pose) - truth[0], [[shift, 0]] * 6, atol=20)


def test_a_view_on_its_side_is_understood(detector, picture, truth):
    turned = np.ascontiguousarray(np.rot90(picture))  # counter-clockwise
    where = Whereabouts(np.array([240.0, 320.0]), turned=90)
    pose = detect_person(detector, turned, None, where)
    upright = np.stack([picture.shape[1] - 1 - pose.points[:, 1], pose.points[:, 0]], axis=1)
    own = upright[[POINT_NAMES.index(name) for name in JOINTS]]
    assert np.median(np.linalg.norm(own - truth[0], axis=1)) < 9


@pytest.mark.parametrize("change", [lambda p: p // 8, lambda p: p[..., 1]])
def test_dark_and_grey_pictures_do(detector, picture, truth, change):
    changed = np.ascontiguousarray(change(picture))
    pose = detector.landmarks(changed, detector.find_people(changed)[0].crop)
    assert np.median(misfit(pose, truth)) < 10


def test_the_command_writes_named_points(detector, recording, truth, tmp_path, monkeypatch):
    monkeypatch.setenv(FOLDER_VARIABLE, os.environ["STEREOTRACK_TEST_DETECTOR"])
    out = tmp_path / "keypoints.csv"
    assert main(["detect", str(recording.folder), "-o", str(out)]) == 0
    rows = [line.split(",") for line in out.read_text().splitlines()]
    assert rows[0][:6] == ["frame", "view", "keypoint", "x", "y", "confidence"]
    own = {row[2]: np.array([float(row[3]), float(row[4])]) for row in rows[1:]}
    assert set(own) <= set(POINT_NAMES)
    for name, place in zip(JOINTS, truth[0], strict=True):
        assert np.linalg.norm(own[name] - place) < 18
    assert all(float(row[5]) >= 0.3 for row in rows[1:])
