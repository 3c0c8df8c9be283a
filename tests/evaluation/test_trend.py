"""A running median follows what most values do."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from stereotrack_core.evaluation.circumstances import trend


def test_a_line_is_followed_though_one_value_in_ten_is_wild():
    rng = np.random.default_rng(0)
    x = rng.uniform(0, 3, 600)
    y = 10 + 5 * x + rng.normal(size=600)
    y[::10] += 500
    found = trend(x, y)
    assert np.abs(found.median - (10 + 5 * found.x)).max() < 2.0
    assert (found.low <= found.median).all()
    assert (found.median <= found.high).all()
    assert (np.diff(found.x) >= 0).all()
    assert (found.count == 90).all()


@given(st.lists(st.tuples(st.floats(0, 9), st.floats(0, 180)), max_size=80))
def test_the_curve_stays_within_its_values_and_does_not_depend_on_their_order(pairs):
    x, y = np.array(pairs).reshape(-1, 2).T
    a, b = trend(x, y), trend(x[::-1], y[::-1])
    np.testing.assert_array_equal(a.x, b.x)
    if len(a.x):
        assert a.low.min() >= y.min()
        assert a.high.max() <= y.max()
