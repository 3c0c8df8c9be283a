"""The low-pass lets through what it says, and velocities are those of the movement."""

from __future__ import annotations

import numpy as np
import pytest

from stereotrack_core.evaluation.joint_angles.definitions import NAMES
from stereotrack_core.evaluation.joint_angles.motion import (
    SHORTEST,
    low_pass,
    motion_of,
    range_of_motion,
)
from stereotrack_core.recording.description import Segment
from tests.evaluation.joint_angles.test_series import angles

NAME = "left_elbow_flexion"
K = NAMES.index(NAME)


def sine(hertz, fps, seconds=10.0):
    return np.sin(2 * np.pi * hertz * np.arange(round(seconds * fps)) / fps)


@pytest.mark.parametrize("fps", [25.0, 100.0])
def test_half_the_power_is_let_through_at_the_cut_off_and_nothing_lags(fps):
    middle = slice(round(3 * fps), round(7 * fps))
    for hertz, gain in ((0.5, 1.0), (6.0, 2**-0.5)):
        through = low_pass(sine(hertz, fps), fps, 6.0)[middle]
        given = sine(hertz, fps)[middle]
        assert through @ given / (given @ given) == pytest.approx(gain, rel=0.02)
        shifted = through - gain * given
        assert np.abs(shifted).max() < 0.03


def test_velocity_is_that_of_the_movement():
    fps, hertz = 100.0, 1.0
    w = 2 * np.pi * hertz
    motion = motion_of(angles(sine(hertz, fps), NAME), fps)
    t = np.arange(1000) / fps
    inside = slice(50, -50)
    np.testing.assert_allclose(motion.velocity[inside, K], (w * np.cos(w * t))[inside], atol=0.03)
    assert np.isfinite(motion.velocity[[0, -1], K]).all()
    assert (motion.cut_off, "6 Hz" in motion.words) == (6.0, True)


def test_gaps_are_not_filtered_across_and_short_stretches_not_at_all():
    values = np.concatenate([np.zeros(20), np.full(20, 2.0), np.full(SHORTEST - 1, 1.0)])
    frame = np.concatenate([np.arange(20), np.arange(25, 45), np.arange(50, 49 + SHORTEST)])
    motion = motion_of(angles(values, NAME, frame), 30.0)
    np.testing.assert_allclose(motion.angle[:20, K], 0.0, atol=1e-12)
    np.testing.assert_allclose(motion.velocity[20:40, K], 0.0, atol=1e-9)
    assert np.isnan(motion.angle[40:, K]).all()
    assert np.isnan(motion.velocity[40:, K]).all()
    values[7] = np.nan
    motion = motion_of(angles(values, NAME, frame), 30.0)
    assert np.isnan(motion.angle[7, K])
    assert np.isfinite(np.delete(motion.angle[:40, K], 7)).all()


def test_ranges_are_taken_per_segment():
    fps = 50.0
    both = angles(1.0 + 0.4 * sine(0.5, fps, 8), NAME, sigma=0.03)
    motion = motion_of(both, fps)
    named = [Segment("quarter", 0, 25), Segment("late", 380, 500), Segment("after", 900, 950)]
    whole, still, late, after = range_of_motion(both, motion, named)
    assert [(one.first, one.end) for one in (still, late, after)] == [
        (0, 25),
        (380, 400),
        (900, 950),
    ]
    assert (whole.name, whole.first, whole.end) == ("all", 0, 400)
    elbow = whole.of(NAME)
    assert elbow.range == pytest.approx(0.8, rel=0.01)
    assert elbow.range_sigma == pytest.approx(np.hypot(0.03, 0.03))
    assert elbow.peak_velocity == pytest.approx(0.4 * np.pi, rel=0.02)
    assert elbow.mean == pytest.approx(1.0, abs=0.01)
    assert still.of(NAME).range == pytest.approx(0.4, rel=0.05)
    assert (after.of(NAME).frames, np.isnan(after.of(NAME).range)) == (0, True)
    with pytest.raises(KeyError):
        whole.of("nothing")
