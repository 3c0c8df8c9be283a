"""What speaks against arms that nobody can hold."""

from __future__ import annotations

import numpy as np
import pytest

from stereotrack_core.body.model import body_model
from stereotrack_core.body.proportions import AVERAGE
from stereotrack_core.tracking.arm_search.arms import LEFT, RIGHT, Arms, arm_shape
from stereotrack_core.tracking.arm_search.score import anatomy_cost

BODY = body_model(AVERAGE)


def cost(side, upper, fore):
    """Cost of one arm, given as a right arm's directions in the torso's frame."""
    outwards = np.array([-1.0 if side == LEFT else 1.0, 1.0, 1.0])
    units = [np.array(v, float) * outwards / np.linalg.norm(v) for v in (upper, fore)]
    arms = Arms(units[0][None], units[1][None])
    return float(anatomy_cost(BODY, arm_shape(BODY, side), arms)[0])


@pytest.mark.parametrize("side", [LEFT, RIGHT])
@pytest.mark.parametrize(
    ("upper", "fore"),
    [((1, 0, 0), (1, 0, 0)), ((0.2, 0, -1), (0, 1, 0)), ((0, 1, 0), (-0.3, 1, 0))],
    ids=["sideways", "elbow bent forward", "reaching"],
)
def test_usual_arms_cost_nothing(side, upper, fore):
    assert cost(side, upper, fore) == 0.0


@pytest.mark.parametrize("side", [LEFT, RIGHT])
@pytest.mark.parametrize(
    ("upper", "fore"),
    [
        ((1, 0, 0), (-1, 0.1, 0)),
        ((0, -1, 0), (0, -1, 0)),
        ((1, 0, 0), (0, -1, 0)),
        ((0.1, 0.1, -1), (-1, -0.2, 0)),
    ],
    ids=["folded", "behind", "bent backward", "through the trunk"],
)
def test_arms_that_nobody_can_hold_cost(side, upper, fore):
    assert cost(side, upper, fore) > 1.0


def test_left_and_right_arms_are_mirror_images(rng):
    for _ in range(100):
        upper, fore = rng.normal(size=(2, 3))
        assert cost(LEFT, upper, fore) == pytest.approx(cost(RIGHT, upper, fore), abs=1e-9)
