"""What a reference says of itself is stated in the units of the errors."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.annotation.reference import Reference
from stereotrack_core.evaluation.accuracy import accuracy_of, reference_quality, stated_means
from stereotrack_core.evaluation.summary import errors_against, summarise
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


def test_weights_leave_equal_errors_alone_and_trust_what_is_known_well():
    errors = errors_against(*(LandmarkTrajectory(np.arange(40), bodies(40)) for _ in range(2)))
    wrong = replace(errors, forearm=np.radians(np.tile([[2.0], [6.0]], (20, 2))))
    alike = {"forearms": np.full((40, 2), 3.0)}
    plain, same = (summarise(wrong, sigmas=own).measure("forearms") for own in (None, alike))
    for name in ("mean", "median", "p95", "count"):
        one, two = (getattr(own.statistics, name) for own in (plain, same))
        assert two == pytest.approx(one, rel=0.02), name
    sure = {"forearms": np.tile([[1.0], [50.0]], (20, 2))}
    assert summarise(wrong, sigmas=sure).measure("forearms").statistics.mean < 2.1
    half = {"forearms": np.tile([[1.0], [np.nan]], (20, 2))}
    assert np.isfinite(summarise(wrong, sigmas=half).measure("forearms").statistics.mean)
    equal = replace(errors, forearm=np.radians(np.full((40, 2), 5.0)))
    assert summarise(equal, sigmas=sure).measure("forearms").statistics.p95 == pytest.approx(5.0)


def test_a_run_is_measured_by_what_the_reference_knows():
    points, sigma = bodies(40), np.where(np.arange(40) < 20, 0.01, 0.08)
    covariance = np.square(sigma)[:, None, None, None] * np.eye(3) * np.ones((1, 9, 1, 1))
    stated = Reference(np.arange(40), points, covariance, np.tile(sigma[:, None] * 100, 6))
    found = LandmarkTrajectory(np.arange(40), points + np.array([0.01, 0.0, 0.0]))
    near = accuracy_of(found, stated.trajectory(0.05), stated)
    assert (near.summary.frames, near.quality["forearms"]) == (20, pytest.approx(1.0))
    wide = accuracy_of(found, stated.trajectory(0.2), stated, weigh=True)
    assert (wide.summary.frames, wide.quality["forearms"]) == (40, pytest.approx(5.7, abs=0.1))
    assert "of which the reference's own is 1.0" in " ".join(stated_means(near))
