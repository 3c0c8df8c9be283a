"""Keypoints with a detector's errors."""

import numpy as np

from stereotrack_core.recording.landmarks import LandmarkTrajectory
from tests.simulated_keypoints import KeypointErrors, simulated_keypoints
from tests.tracking.recordings import camera_towards_the_middle
from tests.tracking.scenes import CAMERAS

CAMERA = camera_towards_the_middle("N", CAMERAS[0])
POINTS = np.array(
    [
        *([-0.18, 0, 1.4], [0.18, 0, 1.4], [-0.3, 0, 1.15], [0.3, 0, 1.15]),
        *([-0.3, 0.3, 1.1], [0.3, -0.3, 1.1], [0, 0, 1.6], [-0.1, 0, 0.95], [0.1, 0, 0.95]),
    ]
)
TRUTH = LandmarkTrajectory(np.arange(400), np.tile(POINTS, (400, 1, 1)))


def test_errors_are_as_stated_and_repeatable():
    errors = KeypointErrors(noise=2.0, gross=0.1, exchanged=0.1)
    found = simulated_keypoints(TRUTH, {"N": CAMERA}, errors, seed=1)
    assert found.fingerprint() == simulated_keypoints(TRUTH, {"N": CAMERA}, errors, 1).fingerprint()
    assert found.fingerprint() != simulated_keypoints(TRUTH, {"N": CAMERA}, errors, 2).fingerprint()
    own = found[found.keypoint == "left_elbow"]
    off = np.linalg.norm(own.place - CAMERA.project(POINTS[2]), axis=1)
    assert 0.7 < np.mean(off < 6.0) < 0.9
    assert 1.5 < np.median(off) < 3.0
    assert 0.0 <= found.confidence.min() <= found.confidence.max() <= 1.0


def test_what_the_trunk_hides_is_missing_or_guessed():
    errors = KeypointErrors(noise=0.5, gross=0.0, exchanged=0.0)
    behind = POINTS.copy()
    behind[4] = [0.0, -0.35, 1.2]  # the left hand, behind the back as seen from the north
    behind[2] = [-0.25, -0.2, 1.2]
    truth = LandmarkTrajectory(TRUTH.frame, np.tile(behind, (400, 1, 1)))
    found = simulated_keypoints(truth, {"N": CAMERA}, errors)
    left, right = (found[found.keypoint == f"{side}_wrist"] for side in ("left", "right"))
    assert 120 < len(left) < 280
    assert len(right) == 400
    assert left.place.std(axis=0).min() > 3.0 * right.place.std(axis=0).max()
    assert left.confidence.max() < 0.6 <= right.confidence.min()
