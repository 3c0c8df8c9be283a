"""Angles over time: without jumps, their ranges, and how far off they are."""

import numpy as np
import pytest

from stereotrack_core.evaluation.joint_angles import (
    NAMES,
    JointAngles,
    angle_errors,
    angle_ranges,
    angles_of_run,
    angles_of_trajectory,
    unwrapped,
)
from stereotrack_core.recording.description import Segment
from stereotrack_core.recording.folder import open_recording
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run import track
from stereotrack_core.tracking.run_spec import RunSpec

TURN, PLANE = (NAMES.index(name) for name in ("torso_turn", "left_shoulder_plane"))


def angles(values, name, frame=None):
    table = np.full((len(values), len(NAMES)), np.nan)
    table[:, NAMES.index(name)] = values
    return JointAngles(np.arange(len(values)) if frame is None else np.asarray(frame), table)


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


def test_errors_go_the_short_way_round():
    truth = angles(np.radians([179.0, 10.0, 20.0, 30.0]), "torso_turn", [0, 1, 2, 3])
    found = angles(np.radians([-179.0, 13.0, 20.0]), "torso_turn", [0, 1, 7])
    errors = angle_errors(found, truth)
    error = errors["torso_turn"]
    assert (error["frames"], error["mean_error"], error["p95"]) == pytest.approx((2, 2.5, 2.95))
    nothing = errors["left_elbow_flexion"]
    assert (nothing["frames"], np.isnan(nothing["rms"])) == (0, True)


def test_ranges_are_taken_per_segment():
    name = "left_elbow_flexion"
    bent = angles(np.radians(60.0 + 20.0 * np.sin(np.linspace(0.0, 4.0 * np.pi, 401))), name)
    named = [Segment("quarter", 0, 50), Segment("late", 380, 500), Segment("after", 900, 950)]
    whole, quarter, late, after = angle_ranges(bent, named)
    ends = [(one.first, one.end) for one in (whole, quarter, late, after)]
    assert ends == [(0, 401), (0, 50), (380, 401), (900, 950)]
    assert whole.angles[name]["range"] == pytest.approx(40.0)
    assert whole.angles[name]["mean"] == pytest.approx(60.0)
    assert quarter.angles[name]["minimum"] == pytest.approx(60.0)
    assert (after.angles[name]["frames"], np.isnan(after.angles[name]["range"])) == (0, True)


@pytest.mark.slow
def test_angles_of_an_accurate_run_are_as_good_as_documented(shared_recording):
    recording = open_recording(shared_recording("mesh-P2"))
    run = track(recording, RunSpec(preset("accurate"), preset="accurate", frames=range(60), seed=0))
    errors = angle_errors(angles_of_run(run), angles_of_trajectory(recording.reference))
    median = {name.removeprefix("right_"): one["median"] for name, one in errors.items()}
    assert median["torso_turn"] < 4.0
    assert median["torso_forward"] < 4.0
    assert median["shoulder_elevation"] < 6.0
    assert median["elbow_flexion"] < 8.0
    assert median["shoulder_plane"] < 12.0
    assert all(one["frames"] > 30 for one in errors.values())
