"""Alternatives of an arm: what is carried along when an upper arm is turned."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from stereotrack_core.tracking.failure.alternatives import _around, _carried


@given(st.integers(0, 2**32 - 1))
def test_what_hangs_on_a_turned_arm_turns_the_shortest_way(seed):
    rng = np.random.default_rng(seed)
    arm, other = (v / np.linalg.norm(v) for v in rng.normal(size=(2, 3)))
    turned = _around(arm)
    for to, found in zip(turned, _carried(arm, turned, other), strict=True):
        axis = np.cross(arm, to)
        angle = np.arccos(np.clip(arm @ to, -1.0, 1.0))
        shortest = Rotation.from_rotvec(angle * axis / np.linalg.norm(axis))
        assert found == pytest.approx(shortest.apply(other), abs=1e-9)
