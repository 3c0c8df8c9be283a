"""Keypoints tell which way a person faces, where a cloud looks much alike from behind."""

from __future__ import annotations

from dataclasses import replace

import pytest

from stereotrack_core.tracking.initialise.finder import TURN_GAIN, PoseFinder
from stereotrack_core.tracking.initialise.trunk import turned_round
from stereotrack_core.tracking.presets import preset
from stereotrack_core.tracking.state import Setup
from tests.tracking.keypoints.cases import BODY
from tests.tracking.keypoints.test_reprojection import seen
from tests.tracking.scenes import CAMERAS, POSES, cloud_of, surface_points


@pytest.mark.parametrize("name", POSES)
def test_a_pose_the_other_way_round_is_turned(name, rng):
    setup = Setup(BODY, preset("accurate").tracking, CAMERAS, 10.0, 0)
    finder, pose = PoseFinder(setup), POSES[name]
    cloud = cloud_of(surface_points(BODY, pose, 600, rng))
    with_keypoints = replace(cloud, keypoints=seen(pose))
    for other, sign in ((turned_round(pose), 1.0), (pose, -1.0)):
        alone = finder.gain_of_turning(other, cloud)
        gain = finder.gain_of_turning(other, with_keypoints)
        assert sign * (gain - alone) > 2.0 * TURN_GAIN
