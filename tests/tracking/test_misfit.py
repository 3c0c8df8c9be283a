"""Signs of a run in which nothing fits."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from stereotrack_core.body.model import body_model, landmarks
from stereotrack_core.body.pose import hanging_pose
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.depth.cloud import PointCounts
from stereotrack_core.recording.keypoints import keypoints_of
from stereotrack_core.tracking import run_checks
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.frame import TrackedFrame, cloudless
from stereotrack_core.tracking.initialise.trunk import turned_round
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.run_checks import MOST_CONTRADICTED, MOST_UNEXPLAINED, misfits
from tests.tracking.scenes import turned

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


@pytest.mark.parametrize(
    ("frames", "told"),
    [
        ([frame(0.1, 0.029)] * 3, None),
        ([frame(0.1, 0.031)] * 3, "3 % of the points"),
        ([frame(0.29)] * 3, None),
        ([frame(0.31)] * 3, "31 % of the cloud"),
        ([frame(0.1, lost=0.119)] * 14, None),
        ([frame(0.1, lost=0.121)] * 14, "12 % of the arms"),
        ([frame(0.1, lost=0.9)] * 13, None),
    ],
)
def test_limits_of_what_is_sound(frames, told):
    found = misfits(frames, preset("fast"))
    assert [words.split(" (")[0].startswith(told or "") for words in found] == [True] * bool(told)
    plain = preset("fast").replaced(legs=False)
    assert len(misfits(frames, plain)) == len([w for w in found if "of the cloud" not in w])


@pytest.mark.parametrize(("what", "least"), [("noise", 6.0), ("blur", 0.7)])
@pytest.mark.parametrize(("share", "told"), [(0.98, 0), (1.02, 1)])
def test_limits_of_poor_pictures(what, least, share, told):
    counts = {"N": PointCounts(**{what: share * least}), "S": PointCounts(**{what: 0.4})}
    frames = [replace(frame(0.2), cloud=cloudless(0, counts=counts))] * 3
    assert len(misfits(frames, preset("fast"))) == told


@pytest.mark.parametrize(("degrees", "told"), [(119.0, 0), (121.0, 1)])
def test_shoulders_that_turn_by_120_degrees_at_once_have_turned_round(degrees, told):
    body, frames = body_model(AVERAGE), []
    for k in range(8):
        pose = turned(POSE, degrees * (k % 2))
        frames.append(replace(frame(0.2), frame=k, landmarks=landmarks(body, pose)))
    found = misfits(frames, preset("fast"))
    assert len(found) == told
    assert not told or "(1, 2, 3, 4, 5 ...)" in found[0]


@pytest.mark.parametrize(("beside", "told"), [(2, 0), (3, 1)])
def test_a_fifth_of_a_camera_s_keypoints_may_lie_beside_the_person(beside, told):
    frames = []
    for k in range(10):
        rows = [(k, c, "nose", 1.0, 2.0, float(c == "B" or k >= beside), "x", 0) for c in "AB"]
        frames.append(replace(frame(0.2), frame=k, keypoints=keypoints_of(rows)))
    found = misfits(frames, preset("fast"))
    assert len(found) == told
    assert not told or "in 3 of the 10 images of camera A " in found[0]


@pytest.mark.parametrize(("late", "told"), [(2, 0), (3, 1)])
def test_a_view_may_be_left_out_in_a_twentieth_of_the_frames(late, told):
    problem = {"W": "View W contradicts the others and is not used: its contours lie off."}
    frames = [
        replace(frame(0.2), frame=k, cloud=cloudless(k, problem if k < late else {}))
        for k in range(40)
    ]
    assert len(misfits(frames, preset("fast"))) == told


def _disagreeing(monkeypatch, shares, count, off=0.16):
    """Clauses on keypoints k0, k1 ... that are `off` metres away in these shares of pictures."""
    names, place = tuple(f"k{k}" for k in range(len(shares))), np.zeros((len(shares), 1, 2))
    fits = [
        SimpleNamespace(
            seen=SimpleNamespace(names=names, cameras=("cam",), pixel=place + [3.0 + k, 4.0 * off]),
            predicted=place + [3.0, 0.0],
            off=np.array([[off if k < share * count - 1e-9 else 0.0] for share in shares]),
        )
        for k in range(count)
    ]
    monkeypatch.setattr(run_checks, "keypoints_in_views", lambda *_: None)
    monkeypatch.setattr(run_checks, "keypoint_fits", lambda *_: fits)
    views = [SimpleNamespace(image=SimpleNamespace(camera="cam"), name="N")]
    seen = SimpleNamespace(views=views), ("N",), ()
    return run_checks.disagreeing_keypoints([(0, POSE)], body_model(AVERAGE), *seen)


@pytest.mark.parametrize(
    ("share", "count", "off", "told"),
    [
        (0.5, 10, 0.16, False),
        (0.6, 10, 0.16, True),
        (0.6, 10, 0.14, False),
        (0.3, 80, 0.16, False),
        (0.3, 100, 0.16, True),
        (1.0, 5, 0.16, True),
        (1.0, 4, 0.16, False),
    ],
)
def test_keypoints_disagree_that_are_surely_off_in_a_fifth_of_the_pictures(
    share, count, off, told, monkeypatch
):
    found = _disagreeing(monkeypatch, [share], count, off)
    median = np.median(np.hypot(np.arange(count), 4.0 * off))
    assert bool(found) == told
    assert not told or f": k0 in N ({100 * share:.0f} %, median {median:.0f} px);" in found[0]


def test_keypoints_that_disagree_most_are_named_and_the_others_counted(monkeypatch):
    [found] = _disagreeing(monkeypatch, [0.6, 0.7, 0.8, 0.9, 1.0, 0.6, 0.7, 0.1, 0.8], 10)
    order = [found.index(f"k{k} in N") for k in (4, 3, 2, 8, 1, 6)]
    assert order == sorted(order)
    assert " and 2 more; " in found
    assert _disagreeing(monkeypatch, [0.1], 10) == ()


def test_stretches_of_frames_are_joined_whose_reasons_differ_in_numbers():
    told = [(3, "12 points"), (4, "7 points"), (5, "8.5 points"), (7, "8 points"), (8, "gone")]
    found = [(gap.first, gap.end, gap.reason) for gap in run_checks.gaps_of(told)]
    assert found == [(3, 6, "7 to 12 points"), (7, 8, "8 points"), (8, 9, "gone")]
