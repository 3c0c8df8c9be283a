"""Signs of a run in which nothing fits."""

import numpy as np
import pytest

from stereotrack_core.body.pose import hanging_pose
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.frame import TrackedFrame, cloudless
from stereotrack_core.tracking.misfit import MOST_ASIDE, MOST_UNEXPLAINED, misfits
from stereotrack_core.tracking.presets import PRESETS, preset


def frames(unexplained, aside=0.0, *, lost=0):
    """Frames with these signs, and some that were not tracked."""
    nobody = Estimate(
        False, "gone", hanging_pose(np.zeros(3)), np.zeros(3), np.eye(3), unexplained_fraction=0.9
    )
    pose = hanging_pose(np.zeros(3))
    seen = [
        Estimate(True, "", pose, np.zeros(3), np.eye(3), unexplained_fraction=value, aside=aside)
        for value in unexplained
    ]
    every = [*seen, *[nobody] * lost]
    return [TrackedFrame(k, e, np.zeros((9, 3)), cloudless(k), {}) for k, e in enumerate(every)]


def test_sound_runs_and_runs_of_nothing_are_not_warned_of():
    sound = np.full(9, MOST_UNEXPLAINED - 0.01)
    sound[:4] = 0.8  # an arm that is lost for a while is no wrong calibration
    assert misfits(frames(sound, MOST_ASIDE - 0.01, lost=20), preset("fast")) == ()
    assert misfits(frames([], lost=3), preset("fast")) == ()


@pytest.mark.parametrize(
    ("signs", "word"),
    [
        ((np.full(3, MOST_UNEXPLAINED + 0.01), 0.0), "27 % of the cloud"),
        ((np.full(3, 0.1), MOST_ASIDE + 0.01), "31 % of the points"),
    ],
)
def test_far_more_than_sound_recordings_have_is_warned_of(signs, word):
    [warning] = misfits(frames(*signs), preset("fast"))
    assert word in warning


def test_of_bodies_without_legs_nothing_is_said():
    signs = frames(np.full(3, 0.5), 0.5)
    silent = [name for name in PRESETS if not misfits(signs, preset(name))]
    assert silent == ["thesis"]
