"""Runs are compared over the frames they share, in the measures that ``evaluate`` prints."""

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.errors import InputError
from stereotrack_core.evaluation.compare import Candidate, compare, how_it_is_made, verdict
from stereotrack_core.evaluation.summary import errors_against, summarise
from stereotrack_core.recording.landmarks import LANDMARKS, LandmarkTrajectory
from tests.evaluation.test_errors import T_POSE

FRAMES = 240


def truth() -> LandmarkTrajectory:
    return LandmarkTrajectory(np.arange(FRAMES), np.tile(T_POSE, (FRAMES, 1, 1)))


def noisy(name: str, sigma: float, seed: int, first: int = 0, end: int = FRAMES) -> Candidate:
    rng = np.random.default_rng(seed)
    points = np.tile(T_POSE, (end - first, 1, 1))
    points = points + sigma * rng.normal(size=points.shape)
    return Candidate(
        name, LandmarkTrajectory(np.arange(first, end), points), rng.random(end - first)
    )


def test_means_and_differences_are_those_of_evaluate():
    a, b = noisy("a", 0.02, 1, 10), noisy("b", 0.01, 2, 0, 200)
    found = compare((a, b), truth())
    assert found.frames.tolist() == list(range(10, 200))
    (pair,) = found.pairs
    summaries = [
        summarise(errors_against(one.trajectory, truth()).between(10, 200)) for one in (a, b)
    ]
    for measure in summaries[0].measures:
        mine = pair.measure(measure.name)
        other = summaries[1].measure(measure.name)
        assert (mine.measure.label, mine.measure.unit) == (measure.label, measure.unit)
        assert mine.first_mean == pytest.approx(measure.statistics.mean)
        assert mine.second_mean == pytest.approx(other.statistics.mean)
        assert mine.differs
        assert mine.difference < 0
    lost = pair.measure("lost")
    assert (lost.first_mean, lost.second_mean) == tuple(100 * one.lost for one in summaries)


def test_frames_that_are_not_tracked_count_as_evaluate_counts_them():
    a, b = noisy("a", 0.01, 1), noisy("b", 0.01, 2)
    b.trajectory.points[::2] = np.nan
    pair = compare((a, b), truth()).pairs[0]
    assert pair.measure("not_tracked").second_mean == pytest.approx(50.0)
    assert pair.measure("forearms").second_mean > 44.0
    assert pair.measure("lost").difference == pytest.approx(50.0)
    assert pair.apart.frames == FRAMES // 2
    assert pair.apart.measure("forearms").statistics.mean < 20.0


def test_without_a_reference_runs_are_compared_with_each_other():
    a, b = noisy("a", 0.0, 1), noisy("b", 0.0, 2)
    b.trajectory.points[:, LANDMARKS.index("left_hand")] += (0.0, 0.3, 0.0)
    found = compare((a, b), None)
    assert not found.against_reference
    assert {m.measure.name for m in found.pairs[0].measures} == {"unexplained", "not_tracked"}
    apart = found.pairs[0].apart
    assert apart.measure("left_forearm").statistics.median == pytest.approx(45.0)
    assert apart.measure("right_forearm").statistics.mean == pytest.approx(0.0)
    bare = [replace(one, unexplained_fraction=None) for one in (a, b)]
    assert {m.measure.name for m in compare(bare, None).pairs[0].measures} == {"not_tracked"}


def test_several_runs_are_each_compared_with_the_first():
    runs = [noisy("a", 0.02, 1), noisy("b", 0.01, 2), noisy("c", 0.02, 3)]
    found = compare(runs, truth(), range(20, 220))
    assert len(found.frames) == 200
    assert [(pair.first, pair.second) for pair in found.pairs] == [("a", "b"), ("a", "c")]
    words = [verdict(pair.measure("forearms"), pair.first, pair.second) for pair in found.pairs]
    assert words[0].startswith("b is better by ")
    assert " deg (" in words[0]
    assert words[1] == "no significant difference"
    assert "200 frames" in how_it_is_made(found)
    assert found.blocks == (25, 25)


def test_few_frames_are_said_to_be_too_few():
    found = compare((noisy("a", 0.02, 1), noisy("b", 0.01, 2)), truth(), range(5))
    words = verdict(found.pairs[0].measure("forearms"), "a", "b")
    assert words.startswith("b is lower by ")
    assert words.endswith("too few independent frames for an interval")


def test_nothing_to_compare_is_refused():
    a = noisy("a", 0.02, 1)
    with pytest.raises(InputError, match="only one run to compare"):
        compare((a,), truth())
    with pytest.raises(InputError, match="no frame in common"):
        compare((noisy("a", 0.1, 1, 0, 5), noisy("b", 0.1, 1, 5, 9)), None)
    with pytest.raises(InputError, match="and the reference"):
        compare((a, a), truth(), range(500, 600))
