"""Where the bones lie, estimated from a few clicked frames."""

import dataclasses
from functools import cache

import numpy as np
import pytest

from stereotrack_core.annotation.click import Click, measurements
from stereotrack_core.annotation.click_points import ENDS_OF_LENGTHS, MeasuredLength
from stereotrack_core.annotation.fit.fit import ClickFit
from stereotrack_core.annotation.landmark_set import NINE
from stereotrack_core.annotation.personal_subject import (
    ClickedFrame,
    clicked_frame,
    lengths_by_clicks,
    personal_offsets,
)
from stereotrack_core.body.model import body_of_subject, landmarks
from stereotrack_core.body.offsets import offsets_by_landmark, with_offsets
from stereotrack_core.body.pose import Pose, hanging_pose
from stereotrack_core.body.proportions import AVERAGE, Proportions
from stereotrack_core.body.skeleton import FOREARMS, UPPER_ARMS
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.recording.description import Subject
from stereotrack_core.recording.landmarks import LANDMARKS
from tests.annotation.scenes import cameras
from tests.body.test_offsets import BODY

PLANTED = {
    **dict.fromkeys(("left_hip", "right_hip"), (0.0, 0.008, -0.004)),
    **dict.fromkeys(("left_shoulder", "right_shoulder"), (0.0, -0.007, -0.004)),
    **dict.fromkeys(("left_elbow", "right_elbow"), (0.002, 0.0, 0.008)),
}
TRUE = np.array([PLANTED.get(name, (0.0, 0.0, 0.0)) for name in LANDMARKS])


def upright(seed):
    rng = np.random.default_rng(seed)
    torso = rotation_from_vector(np.array([0.0, 0.0, rng.uniform(-3, 3)]))
    pose = hanging_pose(np.array([0.0, 0.0, 0.95]), torso)
    rotations = pose.rotations.copy()
    for part, bent in zip((*UPPER_ARMS, *FOREARMS), (0.5, 0.5, 1.2, 1.2), strict=True):
        turn = np.array([-bent, 0.0, 0.0]) + rng.normal(0.0, 0.2, 3)
        rotations[part] = rotations[part] @ rotation_from_vector(turn)
    return Pose(pose.position, rotations)


def frames_with(sigma, count, offsets=TRUE):
    """Frames whose clicks show planted offsets, sigma metres off along each axis."""
    rng, found = np.random.default_rng(count), []
    for frame in range(count):
        parts = BODY.frames(pose := upright(frame))
        tracked = landmarks(BODY, pose)
        places = with_offsets(tracked, offsets, parts) + rng.normal(0.0, sigma, (9, 3))
        covariance = np.tile(max(sigma, 1e-4) ** 2 * np.eye(3), (9, 1, 1))
        found.append(ClickedFrame(frame, places, covariance, tracked, parts))
    return found


def test_planted_offsets_are_recovered_from_many_frames():
    found = personal_offsets(frames_with(0.004, 60))
    assert len(found.frames) == 60
    assert found.left_out == ()
    assert np.abs(found.offsets - TRUE).max() < 0.003
    assert (np.abs(found.offsets - TRUE) < 4.0 * found.sigma).all()
    degrees, spread = found.lean(AVERAGE.torso_length)
    assert degrees == pytest.approx(np.degrees(-0.015 / AVERAGE.torso_length), abs=4.0 * spread)


def test_an_arm_that_the_tracker_lost_says_nothing():
    frames = frames_with(0.002, 3)
    right = personal_offsets(frames)
    frames[1].places[LANDMARKS.index("left_hand")] += (0.3, 0.0, 0.0)
    found = personal_offsets(frames)
    assert found.left_out == ((1, "left_hand"),)
    assert np.abs(found.offsets - right.offsets).max() < 0.004


@cache
def clicked(sigma_px, count):
    """Frames clicked in four cameras, of a body with planted offsets, fitted like any clicks."""
    rig, rng = cameras("plain"), np.random.default_rng(count)
    fit, found = ClickFit(rig, NINE, AVERAGE), []
    for frame in range(count):
        pose = upright(frame)
        shown = with_offsets(landmarks(BODY, pose), TRUE, BODY.frames(pose))
        clicks = [
            Click(frame, name, landmark, tuple(pixel + rng.normal(0.0, sigma_px, 2)))
            for name, camera in rig.items()
            for landmark, pixel in zip(LANDMARKS, camera.project(shown), strict=True)
        ]
        made = measurements(clicks, NINE.names, max(sigma_px, 1.0))
        found.append(clicked_frame(frame, made, fit, BODY, pose))
    return tuple(found)


@pytest.mark.parametrize(("sigma_px", "count", "share"), [(2.0, 3, 0.85), (2.0, 12, 0.6)])
def test_clicked_landmarks_come_nearer(sigma_px, count, share):
    found = personal_offsets(clicked(sigma_px, count))
    before, after = [], []
    for seed in range(50, 70):
        parts, points = BODY.frames(upright(seed)), landmarks(BODY, upright(seed))
        truth = with_offsets(points, TRUE, parts)
        mended = with_offsets(points, found.offsets, parts)
        before.append(np.linalg.norm(truth - points, axis=1)[TRUE.any(axis=1)])
        after.append(np.linalg.norm(truth - mended, axis=1)[TRUE.any(axis=1)])
    assert np.mean(after) < share * np.mean(before)


def test_offsets_that_the_tracked_body_had_are_left_out():
    (one,) = clicked(2.0, 1)
    known = body_of_subject(Subject("P", **vars(AVERAGE), offsets=offsets_by_landmark(TRUE)))
    again = clicked_frame(0, [], ClickFit(cameras("plain"), NINE, AVERAGE), known, upright(0))
    np.testing.assert_allclose(again.tracked, one.tracked, atol=1e-12)


def measured_of(lengths, sigma, count):
    values = {**dataclasses.asdict(lengths), "elbow_to_hand": lengths.elbow_to_hand}
    names = {name for _, name, _ in ENDS_OF_LENGTHS}
    return {name: MeasuredLength(values[name], sigma, count) for name in names}


def test_clicked_lengths_are_held_to_those_of_people():
    assert lengths_by_clicks({}) == AVERAGE
    tall = Proportions(**{k: 1.1 * v for k, v in dataclasses.asdict(AVERAGE).items()})
    well = lengths_by_clicks(measured_of(tall, 0.001, 400))
    for name, length in dataclasses.asdict(well).items():
        assert length == pytest.approx(getattr(tall, name), rel=0.01)
    rough = lengths_by_clicks(measured_of(tall, 0.08, 3))
    assert AVERAGE.torso_length < rough.torso_length < 1.07 * AVERAGE.torso_length
    torso = {"torso_length": MeasuredLength(tall.torso_length, 0.002, 40)}
    assert lengths_by_clicks(torso).forearm_length > 1.03 * AVERAGE.forearm_length
