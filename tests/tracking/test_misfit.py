"""Signs of a run in which nothing fits."""

import numpy as np
import pytest

from stereotrack_core.body.pose import hanging_pose
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.frame import TrackedFrame, cloudless
from stereotrack_core.tracking.presets import PRESETS, preset
from stereotrack_core.tracking.run_checks import MOST_CONTRADICTED, MOST_UNEXPLAINED, misfits

POSE = hanging_pose(np.zeros(3))
SOUND = (MOST_UNEXPLAINED - 0.01, MOST_CONTRADICTED - 0.01)
WRONG = (MOST_UNEXPLAINED + 0.01, MOST_CONTRADICTED + 0.01)


def frame(unexplained, contradicted=np.nan, *, tracked=True):
    x, P = np.zeros(3), np.eye(3)
    estimate = Estimate(
        tracked, "" if tracked else "gone", POSE, x, P, unexplained_fraction=unexplained
    )
    return TrackedFrame(0, estimate, np.zeros((9, 3)), cloudless(0), {}, contradicted)


def test_sound_runs_and_runs_of_nothing_are_not_warned_of():
    # an arm that is lost for a while, or views in which somebody is half seen, are no calibration
    several = [*[frame(*SOUND)] * 5, *[frame(0.8, 0.5)] * 4]
    assert misfits([*several, *[frame(0.9, tracked=False)] * 20], preset("fast")) == ()
    assert misfits([frame(0.1)] * 3, preset("fast")) == ()
    assert misfits([frame(np.nan, tracked=False)], preset("fast")) == ()
    assert misfits([], preset("fast")) == ()


def test_far_more_than_sound_recordings_have_is_warned_of():
    [unexplained] = misfits([frame(WRONG[0], SOUND[1])] * 3, preset("fast"))
    assert "31 % of the cloud" in unexplained
    apart = [frame(SOUND[0], WRONG[1]), frame(SOUND[0]), frame(SOUND[0])]
    [contradicted] = misfits(apart, preset("fast"))
    assert "the views are inconsistent" in contradicted


def test_views_that_do_not_fit_are_told_where_nothing_was_tracked():
    [contradicted] = misfits([frame(np.nan, WRONG[1], tracked=False)], preset("fast"))
    assert "the views are inconsistent" in contradicted


@pytest.mark.parametrize("name", PRESETS)
def test_a_body_without_legs_leaves_them_unexplained(name):
    told = misfits([frame(*WRONG)], preset(name))
    assert len(told) == (1 if name == "thesis" else 2)
