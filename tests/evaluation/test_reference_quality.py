"""What a reference says of itself is stated in the units of the errors."""

import numpy as np
import pytest

from stereotrack_core.annotation.reference import Reference
from stereotrack_core.evaluation.accuracy import reference_quality
from stereotrack_core.evaluation.summary import errors_against
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory
from tests.annotation.scenes import bodies


def reference(points, sigma=0.02, degrees=3.0):
    frames = len(points)
    covariance = np.broadcast_to(sigma**2 * np.eye(3), (frames, 9, 3, 3))
    return Reference(np.arange(frames), points, covariance.copy(), np.full((frames, 6), degrees))


def test_it_is_the_error_of_references_that_scatter_as_they_say():
    points = bodies(400)
    quality = reference_quality(reference(points), np.arange(400))
    rng = np.random.default_rng(0)
    scattered = points.copy()
    hips = [LANDMARKS.index("left_hip"), LANDMARKS.index("right_hip")]
    scattered[:, hips] += rng.normal(0, 0.02, (400, 1, 3))  # together, as hips do
    shoulders = [LANDMARKS.index("left_shoulder"), LANDMARKS.index("right_shoulder")]
    scattered[:, shoulders] += rng.normal(0, 0.02, (400, 2, 3))
    errors = errors_against(
        LandmarkTrajectory(np.arange(400), scattered), LandmarkTrajectory(np.arange(400), points)
    )
    rms = 1000 * np.sqrt(np.mean(errors.torso_position**2))
    assert quality["torso_position"] == pytest.approx(rms, rel=0.05)
    cross = np.degrees(np.sqrt(np.mean(errors.torso_cross**2)))
    assert quality["torso_cross"] == pytest.approx(cross, rel=0.06)


def test_what_is_not_stated_is_left_out():
    plain = Reference(np.arange(3), bodies(3))
    assert reference_quality(plain, np.arange(3)) == {}
    assert reference_quality(reference(bodies(3)), np.array([99])) == {}
    unknown = reference(bodies(3), degrees=np.nan)
    assert set(reference_quality(unknown, np.arange(3))) == {"torso_position", "torso_cross"}
