"""What a reference says of itself is stated in the units of the errors."""

from __future__ import annotations

import numpy as np
import pytest

from stereotrack_core.annotation.reference import Reference
from stereotrack_core.evaluation.accuracy import reference_quality, stated
from stereotrack_core.evaluation.errors import errors_against
from stereotrack_core.evaluation.summary import summarise
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


def test_limbs_are_pooled_over_the_frames_that_count():
    made = reference(bodies(10))
    made.limb_sigma_deg[:5] = 1.0
    made.limb_sigma_deg[5:, 2] = 7.0  # left upper arm
    quality = reference_quality(made, np.arange(5, 30))
    assert quality["left_upper_arm"] == pytest.approx(7.0)
    assert quality["upper_arms"] == pytest.approx(np.sqrt((49 + 9) / 2))
    assert quality["forearms"] == pytest.approx(3.0)
    measures = {
        one.name for one in summarise(errors_against(made.trajectory(), made.trajectory())).measures
    }
    assert set(quality) == measures


def test_what_is_not_stated_is_left_out():
    plain = Reference(np.arange(3), bodies(3))
    assert reference_quality(plain, np.arange(3)) == {}
    assert reference_quality(reference(bodies(3)), np.array([99])) == {}
    unknown = reference(bodies(3), degrees=np.nan)
    assert set(reference_quality(unknown, np.arange(3))) == {"torso_position", "torso_cross"}


def test_errors_are_stated_with_it():
    assert (
        stated(9.08, "deg", {"forearms": 2.31}, "forearms") == "9.1 deg, reference uncertainty 2.3"
    )
    assert stated(9.08, "deg", {}, "forearms") == "9.1 deg"
    assert stated(float("nan"), "mm", {}, "torso_position") == "- mm"
