"""A reference that does not belong to the measured person is named, with a tested correction."""

import dataclasses
import re

import numpy as np
import pytest
import scipy

from stereotrack_core.body.model import body_model, landmarks
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.doctor.reference import Body, check_reference, limbs_of
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory
from tests.depth.recordings import stereo_recording
from tests.tracking.scenes import pose_with_arms

FRAMES = 40
AT = {name: i for i, name in enumerate(LANDMARKS)}
MIRROR = [
    AT[n.replace("left", "r_").replace("right", "left").replace("r_", "right")] for n in LANDMARKS
]


def waving():
    """Landmarks (F, 9, 3) of a person who walks a little and moves both arms before the body."""
    body, points = body_model(AVERAGE), []
    for k in range(FRAMES):
        a = 0.9 * np.sin(0.25 * k)
        arm = np.array([0.3, np.cos(a), np.sin(a)])
        pose = pose_with_arms(
            arm * [1, 1, 1], arm * [-1, 1, 1], [0, 1, 0.2], [0, 1, 0.2], place=(0.01 * k, 0, 0.95)
        )
        points.append(landmarks(body, pose))
    return np.array(points)


@pytest.fixture(scope="module")
def truth():
    return waving()


@pytest.fixture(scope="module")
def measured(truth):
    """A surface 4 cm from the limbs, as if seen from all around."""
    rng = np.random.default_rng(1)
    bodies = []
    for k in range(0, FRAMES, 5):
        bones = np.repeat(limbs_of(truth[k : k + 1])[0], 12, axis=0)
        ways = rng.normal(size=bones.shape)
        points = bones + 0.04 * ways / np.linalg.norm(ways, axis=1, keepdims=True)
        known = scipy.spatial.cKDTree(points)
        bodies.append(Body(k, known, lambda some: np.zeros(len(some), dtype=bool)))
    return bodies


def found(measured, points, frame=None):
    frame = np.arange(len(points)) if frame is None else frame
    reference = LandmarkTrajectory(frame, points)
    changed = dataclasses.replace(stereo_recording(), reference=reference)
    return list(check_reference(changed, measured))


def test_the_true_reference_has_no_findings(measured, truth):
    assert not found(measured, truth)
    assert not found([], truth)  # nothing measured proves nothing


def test_a_late_reference_is_named_and_measured(measured, truth):
    [finding] = found(measured, truth, np.arange(FRAMES) + 8)
    assert finding.severity == "error"
    assert int(re.search(r"(\d+) frames", finding.what)[1]) == pytest.approx(8, abs=1)
    assert "late" in finding.what
    assert "numbers smaller by about" in finding.remedy
    [early] = found(measured, truth[6:])
    assert int(re.search(r"larger by about (\d+) \(tested", early.remedy)[1]) == pytest.approx(
        6, abs=1
    )


def test_a_world_whose_y_points_up_is_named(measured, truth):
    [finding] = found(measured, truth[..., [0, 2, 1]] * [1, 1, -1])
    assert "its y axis points up" in finding.what
    assert "Write x, -z, y for x, y, z (tested" in finding.remedy


def test_exchanged_sides_are_named(measured, truth):
    [finding] = found(measured, truth[:, MIRROR])
    assert "left and right are exchanged" in finding.what


def test_a_reference_from_elsewhere_is_named(measured, truth):
    [finding] = found(measured, truth + [0.5, 0.4, 0.0])
    assert "another recording" in finding.remedy
