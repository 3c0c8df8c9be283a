"""The state of the fit: what shifts move, and derivatives in closed form."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from stereotrack_core.annotation.fit.state import FitState, Freedom
from stereotrack_core.annotation.landmark_set import NINE
from tests.annotation.fit.scenes import BODY, pose

SEEDS = st.integers(0, 2**16)


def some_state(freedom: Freedom, seed: int) -> FitState:
    rng = np.random.default_rng(seed)
    still = freedom.still(pose(int(rng.integers(0, 40))))
    delta = 0.05 * rng.normal(size=freedom.columns.n)
    return freedom.displaced(still, delta)


@given(SEEDS, st.booleans())
def test_places_move_as_their_derivatives_say(seed, with_depth):
    freedom = Freedom(NINE, BODY, with_depth)
    state = some_state(freedom, seed)
    J = freedom.place_jacobian(state)
    step = 1e-6
    for column in range(freedom.columns.n):
        delta = np.zeros(freedom.columns.n)
        delta[column] = step
        further = freedom.places(freedom.displaced(state, delta))
        nearer = freedom.places(freedom.displaced(state, -delta))
        np.testing.assert_allclose(J[..., column], (further - nearer) / (2 * step), atol=1e-6)


def test_a_still_state_has_the_landmarks_of_the_body():
    freedom = Freedom(NINE, BODY, with_depth=True)
    found = freedom.places(freedom.still(pose(3)))
    np.testing.assert_allclose(found, NINE.places(BODY, BODY.frames(pose(3))), atol=1e-12)


def test_a_shifted_joint_takes_the_parts_beyond_along():
    freedom = Freedom(NINE, BODY, with_depth=False)
    still = freedom.still(pose(0))
    shift = np.zeros((9, 3))
    shift[NINE.names.index("left_shoulder")] = [0.0, 0.0, 0.02]
    moved = freedom.places(FitState(still.pose, shift, still.biases)) - freedom.places(still)
    arm = [NINE.names.index(f"left_{name}") for name in ("shoulder", "elbow", "hand")]
    np.testing.assert_allclose(np.linalg.norm(moved[arm], axis=1), 0.02)
    np.testing.assert_array_equal(np.delete(moved, arm, axis=0), 0.0)
