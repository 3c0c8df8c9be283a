"""Signs of a run in which nothing fits."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.body.model import body_model, landmarks
from stereotrack_core.body.pose import hanging_pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.depth.cloud import PointCounts
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.frame import TrackedFrame, cloudless
from stereotrack_core.tracking.initialise.trunk import turned_round
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run_checks import MOST_CONTRADICTED, MOST_UNEXPLAINED, misfits

POSE = hanging_pose(np.zeros(3))
SOUND = (MOST_UNEXPLAINED - 0.01, MOST_CONTRADICTED - 0.01)
WRONG = (MOST_UNEXPLAINED + 0.01, MOST_CONTRADICTED + 0.01)


def frame(unexplained, contradicted=np.nan, *, tracked=True, lost=0.05):
    x, P, reason = np.zeros(3), np.eye(3), "" if tracked else "gone"
    expected = np.r_[np.nan, np.full(4, lost), np.nan]
    estimate = Estimate(
        tracked, reason, POSE, x, P, unexplained_fraction=unexplained, limb_lost=expected
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


def test_arms_that_the_tracker_itself_takes_for_lost_are_warned_of():
    [lost] = misfits([frame(0.2, lost=0.26)] * 20, preset("fast"))
    assert "26 % of the arms" in lost
    assert misfits([frame(0.2)] * 17 + [frame(0.2, lost=0.5)] * 3, preset("fast")) == ()


def test_a_view_that_was_left_out_for_long_is_warned_of():
    sound = [frame(0.2)] * 30
    problem = {"W": "View W contradicts the others and is not used: its contours lie off."}
    left_out = [replace(frame(0.2), frame=k, cloud=cloudless(k, problem)) for k in range(30, 40)]
    [told] = misfits([*sound, *left_out], preset("fast"))
    assert "view W" in told
    assert "in 10 of 40 frames (30 to 39)" in told
    assert misfits([*sound, left_out[0]], preset("fast")) == ()


def test_a_body_that_turns_round_at_once_is_warned_of():
    facing = {
        side: landmarks(body_model(AVERAGE), pose)
        for side, pose in (("north", POSE), ("south", turned_round(POSE)))
    }
    sides = ["north"] * 4 + ["south"] * 3 + ["north"] * 4
    frames = [replace(frame(0.2), frame=k, landmarks=facing[s]) for k, s in enumerate(sides)]
    [turned] = misfits(frames, preset("fast"))
    assert "(4, 7)" in turned
    assert misfits(frames[:4], preset("fast")) == ()


@pytest.mark.parametrize(("what", "words"), [("noise", "noise of 12"), ("blur", "blur of 12.0 px")])
def test_pictures_that_arms_do_not_bear_are_warned_of(what, words):
    counts = {"N": PointCounts(**{what: 12.0}), "S": PointCounts(**{what: 0.5})}
    [poor] = misfits([replace(frame(0.2), cloud=cloudless(0, counts=counts))] * 3, preset("fast"))
    assert "of view N" in poor
    assert words in poor
