"""Keypoints that lie beside the landmarks of their names."""

from dataclasses import replace

import pytest

from stereotrack_core.recording.keypoint_names import COCO_17
from stereotrack_core.recording.keypoints import keypoints_of
from stereotrack_core.recording.sighted_keypoints import sighted
from stereotrack_core.tracking.parameters import TrackingParameters
from stereotrack_core.tracking.shape_fit import OFFSETS, fitted_offsets
from stereotrack_core.tracking.state import Setup
from tests.tracking.keypoints.cases import BODY, VIEWS
from tests.tracking.keypoints.test_reprojection import predictions
from tests.tracking.scenes import CAMERAS, POSES
from tests.tracking.views import cloud_of_body

SETUP = Setup(BODY, TrackingParameters(), CAMERAS, 10.0, 0)
SEEN = [name for name in COCO_17 if name.endswith(("shoulder", "elbow", "wrist", "hip"))]
PLANTED = {
    "keypoint_shoulder_out": -0.03,
    "keypoint_shoulder_up": -0.025,
    "keypoint_hip_out": -0.03,
    "keypoint_elbow_along": 0.02,
    "keypoint_wrist_along": -0.03,
}


def predicted(planted, pose):
    """Exact keypoints of a detector with planted offsets."""
    body = BODY.with_shape(BODY.shape.replaced(**planted))
    return sighted(keypoints_of(predictions(pose, body=body, names=SEEN)), VIEWS)


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
