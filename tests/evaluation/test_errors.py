"""Errors per frame: geometry that can be checked by hand, and what is missing."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stereotrack_core.evaluation.summary import (
    LimbErrors,
    doubts_against,
    errors_against,
    summarise_segments,
)
from stereotrack_core.geometry.rotation import rotation_from_vector
from stereotrack_core.recording.description import Segment
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory

T_POSE = np.array(
    [
        *([-0.2, 0, 1.4], [0.2, 0, 1.4], [-0.5, 0, 1.4], [0.5, 0, 1.4], [-0.8, 0, 1.4]),
        *([0.8, 0, 1.4], [0, 0, 1.6], [-0.1, 0, 0.9], [0.1, 0, 0.9]),
    ]
)


def trajectory(points, first=0):
    points = np.atleast_3d(points).reshape(-1, 9, 3)
    return LandmarkTrajectory(np.arange(first, first + len(points)), points)


def with_landmark(name, position):
    points = T_POSE.copy()
    points[LANDMARKS.index(name)] = position
    return points


def test_perfect_trajectory_has_no_error():
    errors = errors_against(trajectory(T_POSE), trajectory(T_POSE))
    for name in ("torso_position", "torso_long", "torso_cross", "upper_arm", "forearm"):
        np.testing.assert_allclose(getattr(errors, name), 0.0, atol=1e-12)
    assert errors.tracked.all()


def test_lifted_left_hand_is_the_left_forearm_alone():
    lifted = with_landmark("left_hand", [-0.5, 0.0, 1.7])
    errors = errors_against(trajectory(lifted), trajectory(T_POSE))
    np.testing.assert_allclose(errors.forearm, [[np.pi / 2, 0.0]], atol=1e-12)
    np.testing.assert_allclose(errors.upper_arm, 0.0, atol=1e-12)


@given(st.tuples(*[st.floats(-1, 1)] * 3), st.floats(0.0, 3.0))
def test_shift_moves_the_torso_and_no_axis(shift, angle):
    moved = T_POSE + np.array(shift)
    errors = errors_against(trajectory(moved), trajectory(T_POSE))
    np.testing.assert_allclose(errors.torso_position, np.linalg.norm(shift), atol=1e-12)
    np.testing.assert_allclose(errors.forearm, 0.0, atol=1e-9)

    turned = T_POSE @ rotation_from_vector(np.array([0.0, 0.0, angle])).T
    errors = errors_against(trajectory(turned), trajectory(T_POSE))
    np.testing.assert_allclose(errors.torso_cross, angle, atol=1e-9)
    np.testing.assert_allclose(errors.upper_arm, angle, atol=1e-9)
    np.testing.assert_allclose(errors.torso_long, 0.0, atol=1e-9)


def test_missing_frame_counts_90_degrees_and_500_mm():
    errors = errors_against(trajectory(T_POSE, first=7), trajectory(T_POSE))
    assert not errors.tracked.any()
    np.testing.assert_allclose(errors.torso_position, 0.5)
    np.testing.assert_allclose(errors.torso_long, np.pi / 2)
    np.testing.assert_allclose(errors.forearm, np.pi / 2)


def test_what_the_reference_does_not_know_is_not_scored():
    reference = with_landmark("left_hip", [np.nan] * 3)
    errors = errors_against(trajectory(T_POSE), trajectory(reference))
    assert np.isnan(errors.torso_position).all()
    assert np.isnan(errors.torso_long).all()
    assert not np.isnan(errors.torso_cross).any()
    nothing = errors_against(trajectory(T_POSE), trajectory(np.full((9, 3), np.nan)))
    assert len(nothing.frame) == 0


def test_segments_and_empty_stretches():
    random = np.random.default_rng(0)
    reference = LandmarkTrajectory(np.arange(20), random.normal(0.0, 0.5, (20, 9, 3)))
    run = LandmarkTrajectory(np.arange(10), reference.points[:10])
    segments = [Segment("good", 0, 10), Segment("lost", 10, 20), Segment("outside", 50, 60)]
    good, lost, outside = summarise_segments(errors_against(run, reference), segments)
    assert good.lost == 0.0
    assert good.not_tracked == 0
    assert good.measure("forearms").statistics.p95 == pytest.approx(0.0, abs=1e-6)
    assert lost.lost == 1.0
    assert lost.not_tracked == 10
    assert lost.measure("torso_position").statistics.mean == pytest.approx(500.0)
    assert outside.frames == 0
    assert np.isnan(outside.lost)
    assert np.isnan(outside.measure("upper_arms").statistics.mean)
    with pytest.raises(KeyError):
        good.measure("tail")


def arm_errors(frame, degrees) -> LimbErrors:
    """Errors of the arms (F, 4): upper arms, forearms, in degrees."""
    arms = np.radians(np.asarray(degrees, dtype=float))
    nothing = np.zeros(len(frame))
    return LimbErrors(
        np.asarray(frame), nothing, nothing, nothing, arms[:, :2], arms[:, 2:],
        np.ones(len(frame), dtype=bool),
    )  # fmt: skip


def test_counts_over_the_frames_that_both_know():
    chance = np.full((4, 6), np.nan)
    chance[:, 2:] = [[0.9, 0.1, 0.1, 0.1], [0.9, 0.9, 0.1, 0.1], [0.6, 0.4, 0.2, 0.9], [1, 1, 1, 1]]
    found = doubts_against(
        np.array([3, 4, 5, 9]),
        chance,
        arm_errors([2, 3, 4, 5], [[90] * 4, [80, 5, 5, 5], [10, 50, 60, 44], [np.nan, 46, 5, 5]]),
    )
    assert (found.judged, found.lost, found.called, found.both) == (11, 4, 4, 2)
    assert found.precision == pytest.approx(0.5)
    assert found.recall == pytest.approx(0.5)


def test_nothing_is_known_of_a_run_that_does_not_say():
    found = doubts_against(
        np.arange(3), np.full((3, 6), np.nan), arm_errors(range(3), [[90] * 4] * 3)
    )
    assert found.judged == 0
    assert np.isnan([found.precision, found.recall]).all()
