"""Angles over time: without jumps, and how far off they are."""

from __future__ import annotations

import numpy as np
import pytest

from stereotrack_core.evaluation.joint_angles.definitions import NAMES
from stereotrack_core.evaluation.joint_angles.motion import angle_errors
from stereotrack_core.evaluation.joint_angles.series import JointAngles, unwrapped

TURN, PLANE, FLEXION = (
    NAMES.index(n) for n in ("torso_turn", "left_shoulder_plane", "left_elbow_flexion")
)


def angles(values, name, frame=None, sigma=np.nan):
    table = np.full((len(values), len(NAMES)), np.nan)
    table[:, NAMES.index(name)] = values
    frame = np.arange(len(values)) if frame is None else np.asarray(frame)
    return JointAngles(frame, table, np.where(np.isnan(table), np.nan, sigma))


def wrap(values):
    return np.arctan2(np.sin(values), np.cos(values))


def test_somebody_who_turns_round_and_round_is_followed():
    turn = np.linspace(0.0, 14.0, 60)
    found = unwrapped(np.arange(60), angles(wrap(turn), "torso_turn").angle)
    np.testing.assert_allclose(found[:, TURN], turn, atol=1e-12)


def test_turns_are_counted_on_over_a_gap_and_planes_are_not():
    way = np.linspace(0.0, 14.0, 60)
    way[30:33] = np.nan
    turn = unwrapped(np.arange(60), angles(wrap(way), "torso_turn").angle)[:, TURN]
    np.testing.assert_allclose(turn, way, atol=1e-12)
    plane = unwrapped(np.arange(60), angles(wrap(way), "left_shoulder_plane").angle)[:, PLANE]
    assert np.radians(-135) <= plane[33] < np.radians(225)
    np.testing.assert_allclose(np.diff(plane[33:]), np.diff(way[33:]), atol=1e-12)


def test_errors_go_the_short_way_round_and_are_held_against_what_is_stated():
    truth = angles(np.radians([179.0, 10.0, 20.0, 30.0]), "torso_turn", [0, 1, 2, 3])
    found = angles(np.radians([-179.0, 13.0, 20.0]), "torso_turn", [0, 1, 7], np.radians(1.2))
    error = angle_errors(found, truth)[TURN]
    assert error.frames == 2
    assert np.degrees([error.mean_error, error.p95, error.stated_sigma]) == pytest.approx(
        [2.5, 2.95, 1.2]
    )
    assert error.within_two_sigma == 0.5
    nothing = angle_errors(found, truth)[FLEXION]
    assert (nothing.frames, np.isnan(nothing.rms)) == (0, True)
