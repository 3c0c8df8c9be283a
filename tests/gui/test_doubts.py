"""What is said about limbs that the tracker itself doubts."""

from __future__ import annotations

import dataclasses

import numpy as np

from app.presenters.curves import lanes_of
from app.presenters.judgement import MEASURED_LIMBS, Judgement, doubts
from app.presenters.status import frame_words, number_rows
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.pose import hanging_pose
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.frame import TrackedFrame

LEFT_FOREARM, RIGHT_FOREARM = LIMBS.index("left_forearm"), LIMBS.index("right_forearm")


def frame(lost=None, sigma=None) -> TrackedFrame:
    nothing = Cloud(0, np.empty((0, 3)), np.empty(0, int), np.empty((0, 2), int), (), {})
    chances, spread = np.full(6, np.nan), np.full(6, 3.0)
    chances[2:] = 0.01
    for limb, value in (lost or {}).items():
        chances[limb] = value
    for limb, value in (sigma or {}).items():
        spread[limb] = value
    estimate = Estimate(
        True, "", hanging_pose(np.zeros(3)), np.zeros(24), np.eye(24),
        limb_sigma_deg=spread, limb_lost=chances,
    )  # fmt: skip
    return TrackedFrame(0, estimate, np.full((9, 3), np.nan), nothing, {})


def test_a_limb_that_is_probably_lost_is_named_first():
    tracked = frame({LEFT_FOREARM: 0.8, RIGHT_FOREARM: 0.3}, {LIMBS.index("head"): 30.0})
    assert [doubt.limb for doubt in doubts(tracked)] == ["left_forearm", "right_forearm", "head"]
    words = frame_words(tracked)
    assert words == "left forearm probably lost, right forearm uncertain and 1 more"
    hints = {limb: hint for limb, _, _, hint in number_rows(tracked, None)}
    assert hints["left_forearm"] == "probably lost"
    values = {limb: value for limb, _, value, _ in number_rows(tracked, None)}
    assert values["left_forearm"].endswith("lost 80 %")


def test_all_limbs_are_certain_only_where_they_were_judged():
    assert frame_words(frame()) == "all limbs certain"
    older = frame()
    unknown = dataclasses.replace(older.estimate, limb_lost=np.full(6, np.nan))
    assert frame_words(dataclasses.replace(older, estimate=unknown)) == "limbs not judged"


def test_a_lane_names_the_limbs_that_are_probably_lost():
    chance = np.array([0.1, 0.9, 0.9, 0.2, 0.9])
    lost = {limb: np.full(5, np.nan) for limb in MEASURED_LIMBS} | {"left_forearm": chance}
    limbs = {limb: np.zeros(5) for limb in MEASURED_LIMBS}
    judgement = Judgement("sigma", np.arange(5), limbs, np.ones(5, bool), np.zeros(5), None, lost)
    lane = next(lane for lane in lanes_of(judgement, 5, (), None) if lane.name == "probably lost")
    assert [(span.first, span.last, span.label) for span in lane.values] == [
        (1, 2, "left forearm"),
        (4, 4, "left forearm"),
    ]
