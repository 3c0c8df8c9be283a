"""Distances between segments are the least over both."""

from __future__ import annotations

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from stereotrack_core.geometry.triangulation import segment_distance

ends = hnp.arrays(np.float64, (4, 3), elements=st.floats(-2, 2))


@given(ends)
@example(np.array([[1.0, 0, 0], [0, 0, 0], [0, 1.2e-38, 0], [0, 0, 0]]))
def test_distance_is_the_least_of_all_pairs_of_points(corners):
    a, b, c, d = corners
    share = np.linspace(0, 1, 201)
    one = a + share[:, None] * (b - a)
    two = c + share[:, None] * (d - c)
    least = np.linalg.norm(one[:, None] - two[None], axis=-1).min()
    found = segment_distance(a, b, c, d)
    assert found <= least + 1e-9
    assert found >= least - 0.02 * max(np.linalg.norm(b - a), np.linalg.norm(d - c)) - 1e-9


def test_points_and_parallels():
    o, x, y = np.zeros(3), np.array([1.0, 0, 0]), np.array([0, 1.0, 0])
    assert segment_distance(o, o, x, x) == 1.0
    assert segment_distance(o, x, y, x + y) == 1.0
    assert segment_distance(o, x, 3 * x, 4 * x) == 2.0
    assert np.isnan(segment_distance(o, x, y, np.full(3, np.nan)))
