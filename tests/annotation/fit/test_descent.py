"""Clicks of one frame fitted downhill, from far away and with rough clicks."""

from __future__ import annotations

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stereotrack_core.annotation.fit.context import FitContext, standing
from stereotrack_core.annotation.fit.live import Descent, Expected
from stereotrack_core.annotation.fit.state import pose_sigmas
from stereotrack_core.annotation.landmark_set import NINE
from tests.annotation.fit.scenes import BODY, CAMERAS, clicked, fitting, moved_click, places

NO_TRUNK = ("left_elbow", "right_elbow", "left_hand", "right_hand", "head")


@cache
def context():
    return FitContext(CAMERAS, NINE, BODY.skeleton.proportions)


def descent(seed, usual):
    """A descent for the clicks of a frame, and their scatter."""
    freedom = context().by_clicks.freedom
    clicks = context().clicks(clicked(seed % 20, np.random.default_rng(seed)))
    expected = Expected(usual, pose_sigmas(freedom, 1.0, 60.0, 50.0))
    return Descent(freedom, context().settings, clicks, expected), clicks.sigma


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**16), st.floats(-3.0, 3.0), st.floats(2.0, 60.0))
def test_more_steps_never_cost_more(seed, yaw, scatter):
    usual = standing(BODY, np.array([0.3, -0.2, 1.1]), yaw)
    down, sigma = descent(seed, usual)
    begin = context().by_clicks.freedom.still(usual)
    costs = [down.descend(begin, np.maximum(sigma, scatter), steps)[1] for steps in (0, 1, 3, 9)]
    assert all(one >= other for one, other in pairwise(costs))
    assert costs[-1] < costs[0]


@pytest.mark.parametrize("k", [0, 5, 11])
def test_clicks_without_a_trunk_are_met_all_the_same(k):
    clicks = clicked(k, np.random.default_rng(k), names=NO_TRUNK)
    found = fitting().frame(clicks)
    assert np.median(np.linalg.norm(found.residual_px, axis=1)) < 4.0
    assert (found.outlier_probability < 0.5).all()


@pytest.mark.parametrize("k", [0, 5, 11])
def test_rough_clicks_are_rough_and_no_outliers(k):
    rng = np.random.default_rng(k)
    rough = [moved_click(one, rng.normal(0.0, 12.0, 2)) for one in clicked(k, rng)]
    found = fitting().frame(rough)
    assert (found.outlier_probability < 0.5).mean() > 0.9
    assert 3.0 < found.sigma_factor < 10.0
    assert f"{found.sigma_factor:.1f} times" in found.words[0]
    assert np.median(np.linalg.norm(found.residual_px, axis=1)) < 1.5 * 12.0
    assert np.linalg.norm(found.landmarks_world - places(k), axis=1).mean() < 0.1
