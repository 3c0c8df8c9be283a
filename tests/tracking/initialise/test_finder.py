import numpy as np
import pytest

from stereotrack_core.body.pose import hanging_pose
from stereotrack_core.tracking.initialise.finder import trunks_differ
from tests.tracking.scenes import moved, turned


@pytest.mark.parametrize(
    ("degrees", "metres", "differ"),
    [(18.0, 0.0, False), (22.0, 0.0, True), (0.0, 0.14, False), (0.0, 0.16, True)],
)
def test_trunks_that_differ_are_tried_apart(degrees, metres, differ):
    pose = hanging_pose(np.array([0.1, 0.2, 1.0]))
    assert trunks_differ(pose, moved(turned(pose, degrees), np.array([0.0, metres, 0.0]))) == differ
