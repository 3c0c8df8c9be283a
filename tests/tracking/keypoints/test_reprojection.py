"""Keypoints of a 2-D detector as measurements of the pose."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.body.keypoint_places import keypoint_places
from stereotrack_core.body.manifold import difference
from stereotrack_core.body.model import landmarks
from stereotrack_core.recording.keypoint_names import COCO_17
from stereotrack_core.recording.keypoints import keypoints_of
from stereotrack_core.recording.sighted_keypoints import SightedKeypoints, sighted
from stereotrack_core.tracking.keypoint_step import pose_of_keypoints
from stereotrack_core.tracking.residuals.reprojection import KeypointObservation
from tests.tracking.keypoints.cases import BODY, VIEWS
from tests.tracking.scenes import POSES


def predictions(pose, off=None, body=BODY, names=COCO_17) -> list:
    """Rows of keypoints in all views, moved by `off` at (view, keypoint)."""
    places, frames, rows = keypoint_places(body), body.frames(pose), []
    for name in (name for name in names if name in places):
        place = places[name]
        world = frames.apply(np.array([place.part]), place.point[None])[0]
        for view, camera in VIEWS.items():
            moved = camera.project(world) + (off or {}).get((view, name), 0.0)
            rows.append((0, view, name, *moved, 0.9, "x", 0))
    return rows


def seen(pose, off=None) -> SightedKeypoints:
    return sighted(keypoints_of(predictions(pose, off)), VIEWS)


def at(keypoints: SightedKeypoints, name: str, view: str) -> tuple[int, int]:
    return keypoints.names.index(name), keypoints.cameras.index(view)


def test_other_cameras_contradict_a_gross_error():
    wrong = seen(POSES["t"], {("N", "left_wrist"): 30.0})
    fit = KeypointObservation(wrong, 0.03).fitted(BODY, POSES["t"])
    weight = fit.weight
    assert weight[at(wrong, "left_wrist", "N")] == 0.0
    assert weight[at(wrong, "left_wrist", "S")] > 0.9
    assert weight[at(wrong, "left_elbow", "N")] > 0.9


@pytest.mark.parametrize("names", [("shoulder", "elbow", "wrist", "hip"), ("elbow", "wrist")])
def test_exchanged_sides_are_recognised_in_their_picture(names):
    rows = []
    for frame, view, name, *rest in predictions(POSES["pointing"]):
        side, _, joint = name.partition("_")
        if view == "O" and joint in names:
            side = "right" if side == "left" else "left"
            name = f"{side}_{joint}"
        rows.append((frame, view, name, *rest))
    wrong, right = sighted(keypoints_of(rows), VIEWS), seen(POSES["pointing"])
    fit = KeypointObservation(wrong, 0.03).fitted(BODY, POSES["pointing"])
    for side in ("left", "right"):
        for joint in names:
            k = at(right, f"{side}_{joint}", "O")
            np.testing.assert_allclose(fit.seen.pixel[k], right.pixel[k])


def test_a_pose_comes_of_keypoints_alone_and_faces_the_right_way():
    for pose in POSES.values():
        found = pose_of_keypoints(seen(pose), BODY)
        assert np.degrees(np.abs(difference(found, pose, (2, 3, 4, 5))[3:])).max() < 6.0
        apart = np.linalg.norm(landmarks(BODY, found) - landmarks(BODY, pose), axis=1)
        assert apart.max() < 0.05


def test_rays_that_diverge_meet_nowhere():
    left, aside = VIEWS["N"], VIEWS["N"].camera_from_world
    aside = replace(aside, translation=aside.translation - [0.2, 0.0, 0.0])
    pair, middle = {"L": left, "R": replace(left, camera_from_world=aside)}, left.matrix[:2, 2]
    for inwards, met in ((8.0, True), (-8.0, False)):
        places = [("L", middle + [inwards, 0.0]), ("R", middle - [inwards, 0.0])]
        rows = [(0, name, "head", *place, 0.9, "x", 0) for name, place in places]
        found = sighted(keypoints_of(rows), pair).meeting(0.1)
        assert np.isfinite(found.world).all() == found.agreed.all() == met


def test_half_the_confidence_is_twice_the_standard_deviation():
    sure, pose = seen(POSES["t"]), POSES["t"]
    both = (sure, replace(sure, confidence=0.5 * sure.confidence))
    one, two = (KeypointObservation(k, 1.0).residuals(BODY, pose)[0].variance for k in both)
    np.testing.assert_allclose(two / one, 4.0, rtol=0.02)


@pytest.mark.parametrize("missing", ["left_shoulder", "right_shoulder", "left_hip", "right_hip"])
def test_a_joint_of_the_trunk_that_nobody_sees_is_opposite_to_its_other_side(missing):
    rows = [row for row in predictions(POSES["t"]) if row[2] != missing]
    found = pose_of_keypoints(sighted(keypoints_of(rows), VIEWS), BODY)
    away = landmarks(BODY, found) - landmarks(BODY, POSES["t"])
    assert np.linalg.norm(away, axis=1).max() < 0.05
