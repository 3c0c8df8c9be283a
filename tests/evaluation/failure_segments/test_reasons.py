"""Verdicts on a search from the cost of the true arms, and parameters that they point to."""

import numpy as np
import pytest

from stereotrack_core.body.pose import hanging_pose
from stereotrack_core.evaluation.failure_segments.reasons import reason_of, reasons_words
from stereotrack_core.tracking.parameters import Settings
from stereotrack_core.tracking.trace import Pair, Proposals, Search, TrueArms
from stereotrack_core.tracking.tuning.remedy import changes, without_parts

POSE = hanging_pose(np.zeros(3))
DOWN = np.array([0.0, 0.0, -1.0])
AHEAD = np.array([0.0, 1.0, 0.0])


def pair(chosen=False, **terms):
    return Pair(POSE, POSE, terms, sum(terms.values()), chosen)


def costs(data=0.0, change=0.0, pictures=0.0):
    return {"data": data, "keypoints": 0.0, "change": change, "pictures": pictures}


def searched(true, off=(80.0, 0.0, 0.0, 0.0), points=(40, 40, 40, 40), proposals=(), chosen=None):
    """A search whose chosen arms cost 100 by data."""
    truth = TrueArms(
        given=pair(**true), refined=pair(**true), upper=np.array([AHEAD, DOWN]),
        fore=np.array([AHEAD, DOWN]), off=np.radians(off), points=np.array(points), measured=450,
    )  # fmt: skip
    followed = pair(chosen is None, **costs(data=100.0))
    pairs = () if chosen is None else (pair(True, **chosen),)
    return Search(followed, pairs, tuple(proposals), 3.0, 0.0, truth)


def dropped(kept_near=False):
    """Candidates of the left arm: one near the true arm, which costs more by change."""
    directions = np.array([AHEAD, DOWN])
    terms = {"data": np.array([20.0, 60.0]), "change": np.array([90.0, 0.0])}
    return Proposals(0, directions, directions, terms, np.array([kept_near, True]))


@pytest.mark.parametrize(
    ("search", "why", "term", "parameter"),
    [
        (searched(costs(data=80.0)), "search", "", "search_proposals"),
        (searched(costs(data=80.0), proposals=[dropped(kept_near=True)]), "search", "", ""),
        (searched(costs(data=80.0), proposals=[dropped()]), "cost", "change", "sigma_joint"),
        (searched(costs(data=95.0, change=12.0)), "cost", "change", "sigma_joint"),
        (searched(costs(data=98.5)), "cost", "gain", ""),
        (searched(costs(data=98.5), chosen=costs(data=100.0)), "search", "", ""),
        (searched(costs(pictures=130.0)), "cost", "pictures", "background_threshold"),
        (searched(costs(data=95.0), points=(40, 40, 5, 40)), "data", "", "speckle_size"),
        (searched(costs(data=60.0), points=(40, 40, 5, 40)), "search", "", ""),
        (searched(costs(data=80.0), points=(40, 5, 40, 5)), "search", "", ""),
        (searched(costs(data=80.0), off=(10.0, 20.0, 9.0, 3.0)), "right", "", ""),
    ],
)
def test_the_verdict_follows_from_the_cost_of_the_true_arms(search, why, term, parameter):
    reason = reason_of(search)
    assert (reason.why, reason.term) == (why, term)
    assert not parameter or parameter in reason.parameters
    known = {row.name for row in Settings.rows()}
    assert set(reason.parameters) <= known
    assert bool(reason.parameters) == (why != "right")
    assert reason.words.endswith(".")


def test_verdicts_are_counted_with_their_terms():
    some = [searched(costs(data=80.0)), searched(costs(pictures=130.0)), searched(costs(150.0))]
    counted = reasons_words([*(reason_of(one) for one in some), None])
    assert counted == "cost wrong 2 (pictures 1, data 1), search missed it 1"


def test_each_parameter_is_tried_both_ways_within_its_range():
    tried = changes(Settings(), ["search_refined", "arms_apart", "leave_out_views", "iterations"])
    found = [one.settings.values() for one in tried]
    assert [v["search_refined"] for v in found[:2]] == [2, 6]
    assert [v["arms_apart"] for v in found[2:4]] == [0.0225, 0.09]
    assert found[4]["leave_out_views"] is False
    assert [v["iterations"] for v in found[5:]] == [3, 12]
    assert all(one.words for one in tried)
    names = ["speckle_size", "sigma_joint"]
    assert "sigma" in changes(Settings(), names)[0].words, "clouds are the same and come first"
    highest = changes(Settings().replaced(arms_apart=0.2), ["arms_apart"])
    assert [one.settings.values()["arms_apart"] for one in highest] == [0.1]


def test_parts_are_left_out_one_at_a_time_and_views_too():
    tried = without_parts(Settings(), ("N", "S"))
    assert [one.views for one in tried[-2:]] == [("S",), ("N",)]
    assert {one.words for one in tried} >= {"without arm search", "without motion prior"}
    off = without_parts(Settings().replaced(search_arms=False), ("N",))
    assert "without arm search" not in [one.words for one in off], "it is off already"
