"""What the keypoints of a detector say about the limbs of a pose."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stereotrack_core.body.limbs import LIMBS
from stereotrack_core.body.skeleton import FOREARMS, UPPER_ARMS
from stereotrack_core.tracking.arm_search.arms import LEFT, RIGHT, with_arm
from stereotrack_core.tracking.failure.disagreement import carried_on, disagreement
from tests.tracking.keypoints.cases import BODY
from tests.tracking.keypoints.test_reprojection import seen
from tests.tracking.scenes import POSES

ARMS = [*UPPER_ARMS, *FOREARMS]
DOWN = np.array([0.0, 0.0, -1.0])
TRUE = POSES["t"]
NOTHING = np.zeros((len(LIMBS), 2))


def off_and_sure(pose):
    found = disagreement(seen(TRUE), BODY, pose)
    sure = found[:, 1]
    return found[ARMS, 0] / sure[ARMS], sure


@pytest.mark.parametrize("side", [LEFT, RIGHT])
def test_only_the_arm_that_is_elsewhere_disagrees(side):
    off, sure = off_and_sure(TRUE)
    assert off == pytest.approx(np.zeros(4), abs=1e-6)
    assert sure == pytest.approx([0.0, 0.0, 0.9, 0.9, 0.9, 0.9])
    out = np.array([-1.0 if side == LEFT else 1.0, 0.0, 0.0])
    off, _ = off_and_sure(with_arm(TRUE, side, out, DOWN))  # the forearm alone hangs down
    wrong = ARMS.index(FOREARMS[side])
    assert 0.7 < off[wrong] < 1.5
    assert np.delete(off, wrong) == pytest.approx(np.zeros(3), abs=1e-6)


def test_a_body_that_is_moved_does_not_disagree():
    off, _ = off_and_sure(replace(TRUE, position=TRUE.position + [0.05, 0.1, 0.02]))
    assert (off < 0.1).all()


def test_what_was_said_fades_until_keypoints_come_again():
    hanging = with_arm(TRUE, LEFT, DOWN, DOWN)
    first = carried_on(NOTHING, 0.1, seen(TRUE), BODY, hanging)
    later = carried_on(first, 0.3, None, BODY, hanging)
    np.testing.assert_allclose(later, 0.5 * first)
    again = carried_on(later, 0.3, seen(TRUE), BODY, TRUE)
    assert again[ARMS, 0] == pytest.approx(np.zeros(4), abs=1e-6)
    np.testing.assert_array_equal(carried_on(NOTHING, 0.1, None, BODY, TRUE), NOTHING)


def test_a_hidden_arm_says_nothing():
    one = seen(TRUE)
    hidden = np.array([name.startswith("left_") for name in one.names])[:, None]
    pixel = np.where(hidden[..., None], np.nan, one.pixel)
    one = replace(one, pixel=pixel, confidence=np.where(hidden, 0.0, one.confidence))
    found = disagreement(one, BODY, TRUE)
    np.testing.assert_array_equal(found[[UPPER_ARMS[LEFT], FOREARMS[LEFT]]], 0.0)
    assert (found[[UPPER_ARMS[RIGHT], FOREARMS[RIGHT]], 1] > 0.0).all()
