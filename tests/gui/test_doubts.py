"""What is said about the limbs of a tracked frame: their errors, or what speaks against them."""

import dataclasses

import numpy as np
import pytest

from app.features.track.controller import number_rows
from app.session.judgement import MEASURED_LIMBS, Judgement, doubts
from app.session.runs import RunEntry
from app.session.session import Snapshot
from app.shell.status import frame_words
from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.pose import hanging_pose
from stereotrack_core.depth.cloud import Cloud
from stereotrack_core.tracking.estimate import Estimate
from stereotrack_core.tracking.frame import TrackedFrame
from tests.gui.made_runs import add_run

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


def shown(tracked, judgement=None) -> Snapshot:
    """What panels are shown of a frame."""
    entry = RunEntry("run", "", None, None, range(1), {0: tracked})
    return Snapshot(active=entry, judgements={} if judgement is None else {entry: judgement})


def test_a_limb_that_is_probably_lost_is_named_first():
    tracked = frame({LEFT_FOREARM: 0.8, RIGHT_FOREARM: 0.3}, {LIMBS.index("head"): 30.0})
    assert list(doubts(tracked)) == ["left_forearm", "right_forearm", "head"]
    words = frame_words(tracked)
    assert words == "left forearm likely wrong, right forearm uncertain and 1 more"
    hints = {limb: hint for limb, _, _, hint in number_rows(shown(tracked))}
    assert hints["left_forearm"] == "likely wrong, failure probability 80 %", "not beside the value"


def changed(tracked, **values) -> TrackedFrame:
    return dataclasses.replace(tracked, estimate=dataclasses.replace(tracked.estimate, **values))


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"unexplained_fraction": 0.18, "residual": 0.021}, "no limb flagged"),
        (
            {"unexplained_fraction": 0.5, "residual": 0.021},
            "no limb flagged, but 50 % of the points are unexplained",
        ),
        (
            {"unexplained_fraction": 0.44, "residual": 0.041},
            "no limb flagged, but 44 % of the points are unexplained and points are 41 mm off the "
            "model",
        ),
        ({}, "no limb flagged, but the fit of the model to the points is not known"),
        (
            {"unexplained_fraction": 0.1, "residual": 0.01, "limb_lost": np.full(6, np.nan)},
            "failure not assessed, at most ± 3° (filter estimate)",
        ),
    ],
)
def test_without_a_reference_only_what_is_known_is_said(values, words):
    assert frame_words(changed(frame(), **values)) == words


def against(**errors) -> Judgement:
    """Errors in frame 0; of other limbs the reference knows nothing."""
    limbs = {limb: np.array([errors.get(limb, np.nan)]) for limb in MEASURED_LIMBS}
    return Judgement("error", np.arange(1), limbs, np.ones(1, bool), np.full(1, 0.1), None)


def test_with_a_reference_the_errors_are_said_and_whether_anybody_noticed():
    calm = changed(frame(), unexplained_fraction=0.1, residual=0.01)
    close = against(torso=3.0, left_upper_arm=11.2, left_forearm=4.0)
    assert frame_words(calm, close) == "limbs within 12° of the reference"
    doubted = frame({RIGHT_FOREARM: 0.8})
    words = "limbs within 12° of the reference, right forearm likely wrong"
    assert frame_words(doubted, close) == words
    far = against(torso=3.0, left_forearm=98.2, right_forearm=47.0, left_upper_arm=25.0)
    assert frame_words(doubted, far) == (
        "left forearm 98° off the reference, not flagged; right forearm 47° off the reference, "
        "likely wrong and 1 more"
    )
    hints = {limb: hint for limb, _, _, hint in number_rows(shown(doubted, far))}
    assert hints["left_forearm"].startswith("far off, not flagged")
    assert hints["right_forearm"].startswith("likely wrong")
    assert hints["torso"] == ""
    unknown = against()
    assert frame_words(calm, unknown) == "no limb flagged", "the reference knows nothing here"


@pytest.mark.window
def test_the_status_line_never_calls_a_limb_certain_that_is_off_the_reference(opened, qtbot):
    add_run(opened, "wild", wild=(3,))
    for shown, words in ((2, "limbs within "), (3, "° off the reference, not flagged")):
        opened.context.session.document.go_to(shown)
        qtbot.waitUntil(opened.context.tasks.settled)
        opened.context.actions.refresh()
        assert words in opened.status.state.text()
        assert "certain" not in opened.status.state.text()
