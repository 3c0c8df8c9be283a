"""Keypoints that lie beside the landmarks of their names."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.body.keypoint_places import keypoint_places
from stereotrack_core.body.model import body_model
from stereotrack_core.body.parameters import BodyShape
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.recording.keypoints import keypoints_of
from stereotrack_core.recording.sighted_keypoints import sighted
from stereotrack_core.tracking.keypoint_offsets import OFFSETS, fitted_offsets
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.state import Setup
from tests.tracking.recordings import camera_towards_the_middle
from tests.tracking.scenes import CAMERAS, POSES
from tests.tracking.views import cloud_of_body

BODY = body_model(AVERAGE, BodyShape())
SETUP = Setup(BODY, TrackingParameters(), CAMERAS, 10.0, 0)
WATCHING = {n: camera_towards_the_middle(n, at) for n, at in zip("NOSW", CAMERAS, strict=True)}
SEEN = ("shoulder", "elbow", "wrist", "hip")
PLANTED = {
    "keypoint_shoulder_out": -0.03,
    "keypoint_shoulder_up": -0.025,
    "keypoint_hip_out": -0.03,
    "keypoint_elbow_along": 0.02,
    "keypoint_wrist_along": -0.03,
}


def predicted(planted, pose):
    """Exact keypoints of a detector with planted offsets."""
    other = BODY.with_shape(BODY.shape.replaced(**planted))
    frames, rows = other.frames(pose), []
    for name, place in keypoint_places(other).items():
        if name.split("_")[-1] in SEEN:
            world = frames.apply(np.array([place.part]), place.point[None])
            rows += [
                (0, camera.name, name, *camera.project(world)[0].tolist(), 1.0, "d", 0)
                for camera in WATCHING.values()
            ]
    return sighted(keypoints_of(rows), WATCHING)


@pytest.fixture(scope="module")
def clouds():
    return [(pose, cloud_of_body(BODY, pose)) for pose in list(POSES.values())[:3]]


def found(clouds, planted):
    seen = [(p, replace(cloud, keypoints=predicted(planted, p))) for p, cloud in clouds]
    values = fitted_offsets(SETUP, seen * 8).values()
    return {name: values[name] for name in OFFSETS}


def test_planted_offsets_are_recovered_as_far_as_the_data_tell(clouds):
    offsets = found(clouds, PLANTED)
    for name, planted in PLANTED.items():
        assert 0.5 < offsets[name] / planted < 1.1, name
    assert max(abs(offsets[name]) for name in OFFSETS if name not in PLANTED) < 0.012


def test_a_detector_that_sees_the_landmarks_has_hardly_any(clouds):
    assert max(map(abs, found(clouds, {}).values())) < 0.006
