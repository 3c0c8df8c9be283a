"""Means, intervals and tests of paired series; equals are told apart in about one of twenty."""

import math

import numpy as np
import pytest
from scipy import signal

from stereotrack_core.evaluation.compare import Paired, Series, paired


def series(values) -> Series:
    return Series.of(np.asarray(values, dtype=np.float64))


def alike(share: float, n: int, rng) -> np.ndarray:
    """Errors whose neighbours are alike: absolute values of a first-order process."""
    noise = rng.normal(size=n + 200)
    return np.abs(signal.lfilter([np.sqrt(1 - share**2)], [1, -share], noise)[200:])


def test_a_difference_is_that_of_the_means_over_what_both_know():
    rng = np.random.default_rng(0)
    a, b = rng.random((200, 2)), rng.random((200, 2)) - 0.3
    a[5:9], b[20:30] = np.nan, np.nan
    found = paired(series(a), series(b))
    both = np.isfinite(a + b).all(axis=1)
    assert found.frames == both.sum() == 186
    assert found.first_mean == pytest.approx(a[both].mean())
    assert found.difference == pytest.approx(b[both].mean() - a[both].mean())
    assert found.low < found.difference < found.high < 0.0
    assert found.differs
    assert found.block_frames == 24


def test_equals_are_equal_and_nothing_is_nothing():
    ones = series(np.ones(100))
    found = paired(ones, ones)
    assert (found.difference, found.low, found.high, found.equal) == (0.0, 0.0, 0.0, True)
    assert not found.differs
    nothing = paired(series(np.full(5, np.nan)), series(np.ones(5)))
    assert nothing.frames == 0
    assert math.isnan(nothing.first_mean)
    assert not nothing.enough


def test_few_frames_and_long_excursions_say_that_they_are_too_few():
    rng = np.random.default_rng(2)
    assert not paired(series(rng.random(10)), series(rng.random(10) + 5)).enough
    lost = np.r_[np.zeros(60), np.ones(60)]
    found = paired(series(lost), series(np.zeros(120)))
    assert not found.enough
    assert not found.differs


@pytest.mark.parametrize("share", [0.0, 0.8, 0.95])
def test_equals_with_neighbours_alike_are_told_apart_in_about_one_of_twenty(share):
    rng, runs = np.random.default_rng(5), 600
    told: list[Paired] = [
        paired(series(alike(share, 490, rng)), series(alike(share, 490, rng))) for _ in range(runs)
    ]
    wrong = sum(found.differs for found in told) / runs
    assert 0.01 < wrong < 0.09
    assert sum(found.enough for found in told) > 0.95 * runs
