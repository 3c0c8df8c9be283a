"""Failures of runs made of numbers: found with truth and without, and why."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.evaluation.failure_segments.find import FailureSearch, find_failures
from stereotrack_core.evaluation.failure_segments.segment import UNCLEAR, FailureRules
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory
from stereotrack_core.tracking.presets import preset
from tests.evaluation.failure_segments.runs import FPS, made, untracked

LOST = 0.97


def failures(run, truth=None, **changes):
    return find_failures(FailureSearch(run, FPS, truth, None, FailureRules().replaced(**changes)))


def test_a_limb_far_off_for_long_enough_is_an_failure():
    run, truth = made(wrong=[("left_forearm", 20, 29, 1.2), ("right_forearm", 40, 41, 1.2)])
    (failure,) = failures(run, truth)
    assert (failure.first, failure.last, failure.limbs) == (20, 29, ("left_forearm",))
    assert failure.found == "truth"
    assert failure.peak == pytest.approx(np.degrees(1.2), abs=0.1)
    assert len(failures(run, truth, episode_least=0.2)) == 2
    assert failures(run, truth, episode_error=80.0) == ()


def test_what_the_run_takes_for_lost_is_found_without_truth():
    limbs = ("right_upper_arm", "right_forearm")
    run, _ = made(
        wrong=[(limb, 15, 30, 1.0) for limb in limbs], lost=[(limb, 15, 30, LOST) for limb in limbs]
    )
    assert failures(made()[0]) == ()
    (failure,) = failures(run)
    assert failure.found == "signs"
    assert failure.limbs == ("right_upper_arm", "right_forearm")
    assert abs(failure.first - 15) <= 3
    assert abs(failure.last - 30) <= 3
    assert 0.5 < failure.peak <= 1.0


def test_what_is_not_tracked_is_an_failure_of_all_limbs():
    run, truth = made()
    found = failures(untracked(run, 30, 39), truth)
    assert [(e.first, e.last, e.found) for e in found] == [(30, 39, "signs"), (30, 39, "truth")]
    assert {"torso", "left_forearm", "right_forearm"} <= set(found[0].limbs)


def test_signs_never_see_the_truth():
    run, truth = made(wrong=[("left_forearm", 20, 29, 1.2)], lost=[("left_forearm", 20, 29, LOST)])
    alone = failures(run)
    beside = [e for e in failures(run, truth) if e.found == "signs"]
    assert all(e.error_deg > 45.0 for e in beside)
    assert list(alone) == [replace(e, error_deg=None) for e in beside]


def test_arms_that_cross_are_the_cause():
    run, truth = made(wrong=[("left_forearm", 20, 40, 1.2)])
    points = truth.points.copy()
    hands = [LANDMARKS.index(f"{side}_hand") for side in ("left", "right")]
    elbows = [LANDMARKS.index(f"{side}_elbow") for side in ("left", "right")]
    points[15:45, elbows] = [[-0.3, 0.3, 1.2], [0.3, 0.3, 1.2]]
    points[15:45, hands] = [[0.1, 0.35, 1.2], [-0.1, 0.35, 1.2]]
    found = failures(run, LandmarkTrajectory(truth.frame, points))
    crossed = [e for e in found if e.first <= 20 and e.last >= 40]
    assert {e.verdict.cause for e in crossed} == {"crossing"}
    evidence = crossed[0].verdict.evidence[0]
    assert "apart in frame" in evidence.words
    assert evidence.value < 0.05
    assert 0.3 < crossed[0].verdict.confidence <= 1.0


def test_parameters_that_do_nothing_in_the_run_are_not_pointed_to():
    wrong = [("left_forearm", 0, 20, 1.2), ("left_upper_arm", 0, 20, 1.2)]
    named = {}
    for name in ("accurate", "thesis"):
        run, truth = made(wrong=wrong, meta={"fps": FPS, "parameters": preset(name).values()})
        unclear = replace(failures(run, truth)[0], verdict=UNCLEAR)
        named[name] = unclear.parameters
    assert {"search_proposals", "second_look", "picture_cost"} < set(named["accurate"])
    assert named["thesis"] == ("sigma_joint",)


def test_an_failure_of_the_first_frames_is_laid_to_initialisation():
    run, truth = made(wrong=[("left_forearm", 0, 20, 1.2), ("left_upper_arm", 0, 20, 1.2)])
    assert failures(run, truth)[0].verdict.cause == "initialisation"


def test_a_limb_that_turns_too_fast_is_the_cause():
    run, truth = made(wrong=[("right_forearm", 30, 40, 1.2)])
    points = truth.points.copy()
    elbow, hand = LANDMARKS.index("right_elbow"), LANDMARKS.index("right_hand")
    length = np.linalg.norm(points[0, hand] - points[0, elbow])
    points[29:, hand] = points[29:, elbow] + [0.0, 0.0, length]
    (failure, *_) = failures(run, LandmarkTrajectory(truth.frame, points))
    assert failure.verdict.cause == "fast"
    assert "per second" in failure.verdict.words
