"""Gains are summed up over the frames that profit, whichever way it is computed."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from stereotrack_core.annotation.click_gains import distances, over_frames, shares_around

rows = hnp.arrays(np.bool_, 12)


@given(clicked=rows, reach=st.integers(1, 8), row=st.integers(0, 11))
def test_sums_are_those_of_the_shares(clicked, reach, row):
    gain = np.random.default_rng(1).uniform(1, 2, (12, 2, 1))
    total = over_frames(gain, clicked[:, None], reach)
    near, share = shares_around(row, clicked, reach)
    if not clicked[row]:
        assert total[row] == pytest.approx((share[:, None, None] * gain[near]).sum(axis=0))


@given(clicked=rows, reach=st.integers(1, 8))
def test_distances_are_to_the_nearest_clicks(clicked, reach):
    before, after = (side[:, 0] for side in distances(clicked[:, None], reach))
    places = np.flatnonzero(clicked)
    for row in range(12):
        assert before[row] == min([row - p for p in places if p <= row] + [reach])
        assert after[row] == min([p - row for p in places if p >= row] + [reach])


def test_share_falls_to_nothing_at_the_next_click():
    clicked = np.zeros(20, dtype=bool)
    clicked[[4, 12]] = True
    near, share = shares_around(8, clicked, 6)
    assert near.tolist() == [5, 6, 7, 8, 9, 10, 11]
    assert share == pytest.approx([0.25, 0.5, 0.75, 1.0, 0.75, 0.5, 0.25])
    near, share = shares_around(0, np.zeros(20, dtype=bool), 4)
    assert share == pytest.approx([1.0, 0.75, 0.5, 0.25])
