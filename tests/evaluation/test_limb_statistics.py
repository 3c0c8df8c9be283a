"""Statistics of limbs over a stretch."""

from __future__ import annotations

import numpy as np

from stereotrack_core.evaluation.summary import ALL_ARMS, limb_statistics


def test_every_limb_has_a_row_and_all_arms_together_the_last():
    values = {
        "torso": np.array([1.0, 2.0, np.nan, 3.0]),
        "left_upper_arm": np.array([10.0, 50.0, 20.0, 30.0]),
        "left_forearm": np.array([0.0, 0.0, 60.0, np.nan]),
    }
    lost = {
        "left_upper_arm": np.array([0.0, 1.0, 0.0, 0.0]),
        "left_forearm": np.array([0.0, 0.0, 1.0, np.nan]),
    }
    torso, upper, fore, arms = limb_statistics(values, lost, 25.0)
    assert (torso.limb, torso.count, torso.mean, torso.maximum) == ("torso", 3, 2.0, 3.0)
    assert np.isnan(torso.lost)
    assert (upper.median, upper.above, upper.lost) == (25.0, 0.5, 0.25)
    assert upper.p95 == np.percentile([10, 50, 20, 30], 95)
    assert (fore.above, fore.lost) == (1 / 3, 1 / 3)
    assert (arms.limb, arms.count, arms.above, arms.lost) == (ALL_ARMS, 7, 3 / 7, 2 / 7)


def test_nothing_known_gives_nothing():
    (torso,) = limb_statistics({"torso": np.full(3, np.nan)}, {}, 10.0)
    assert torso.count == 0
    numbers = (torso.mean, torso.median, torso.p95, torso.maximum, torso.above, torso.lost)
    assert np.isnan(numbers).all()
